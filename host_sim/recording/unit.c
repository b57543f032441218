/* davar-sim - units. */
#include "recording/unit.h"

#include "common/text.h"

#define DEG_PER_RAD 57.295779513082320877

unit_t unit_of(const char *column)
{
    if (text_ends_with(column, "_dps")) {
        return UNIT_DPS;
    }
    if (text_ends_with(column, "_rad_s")) {
        return UNIT_RAD_S;
    }
    return text_ends_with(column, "_counts") ? UNIT_COUNTS : UNIT_OTHER;
}

double unit_factor(unit_t unit)
{
    return (unit == UNIT_RAD_S) ? DEG_PER_RAD : 1.0;
}
