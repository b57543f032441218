/* davar - cluster sizes: octaves and a geometric series, both with the 25 % rule 9 m <= window. */
#include "davar/fit.h"

#include "number/machine.h"
#include "number/strict.h"

/* Largest m that the 25 % rule of [FAST] allows, at least 1 (1.3). */
static uint32_t largest(uint32_t window)
{
    return (window < 18U) ? 1U : (window / 9U);
}

DAVAR_RARE uint8_t davar_taus_octave(uint32_t window, uint32_t *taus, uint8_t capacity)
{
    uint8_t count = 0U;
    if (window < 2U) {
        return 0U;
    }
    for (uint32_t m = 1U; (m <= largest(window)) && (count < capacity); m *= 2U) {
        taus[count] = m;
        count++;
    }
    return count;
}

/* The root of x^degree = value >= 1, by bisection: init time, and no libm that differs between
 * targets. */
static double root(double value, uint8_t degree)
{
    double low = 1.0;
    double high = value;
    for (uint32_t i = 0U; i < 100U; i++) {
        const double middle = 0.5 * (low + high);
        double power = 1.0;
        for (uint8_t j = 0U; j < degree; j++) {
            power *= middle;
        }
        if (power > value) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

DAVAR_RARE uint8_t davar_taus_geometric(uint32_t window, uint8_t wanted, uint32_t *taus,
                                        uint8_t capacity)
{
    uint8_t count = 0U;
    if ((window < 2U) || (wanted == 0U)) {
        return 0U;
    }
    const double ratio =
        (wanted > 1U) ? root((double)largest(window), (uint8_t)(wanted - 1U)) : 1.0;
    double exact = 1.0;
    for (uint8_t i = 0U; (i < wanted) && (count < capacity); i++) {
        const uint32_t m = (uint32_t)(exact + 0.5);
        if ((count == 0U) || (m > taus[count - 1U])) {
            taus[count] = m;
            count++;
        }
        exact *= ratio;
    }
    return count;
}
