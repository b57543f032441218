/* davar tests - the plan of a floor that tools/davar-plan wrote equals that of davar_floor_plan.
 *
 * FILTER: calls that fill the filter f; empty: none. RATE, LSB, RAIL, BLOCK: of the samples. Prints the usable
 * frequencies if both are equal. */
#include "davar/filter.h"
#include "davar/floor.h"

#include <stdio.h>
#include <string.h>

extern const davar_floor_plan_t ready;
static davar_floor_plan_t made;

int main(void)
{
    davar_filter_t f = {0};
    FILTER;
    const davar_floor_config_t config = {
        .rate_hz = RATE, .unit_per_count = LSB, .rail = RAIL, .block = BLOCK, .filter = &f};
    const bool is_made = (davar_floor_plan(&made, &config) == DAVAR_FLOOR_OK);
    if (!is_made || (memcmp(&ready, &made, sizeof made) != 0)) {
        return 1;
    }
    (void)printf("%d\n", made.usable);
    return 0;
}
