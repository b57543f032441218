/* davar - the level of a stretch. */
#include "track/level.h"

#include "number/real.h"
#include "number/scaled.h"

double davar_level(const davar_spread_t *sum, uint32_t floor, uint32_t unit)
{
    const davar_spread_t rounding = {davar_multiply_u32(floor, sum->blocks), 0U, 0U};
    const davar_spread_t rest = spread_between(&rounding, sum);
    if ((rest.low == 0U) && (rest.high == 0U)) {
        return 0.0;
    }
    const int32_t exponent = spread_exponent(&rest);
    const scaled_t square = {spread_bits(&rest, exponent), exponent};
    return davar_root_of_quotient(scaled_to_double(square), davar_double_of_u64(davar_multiply_u32(unit, sum->blocks)));
}
