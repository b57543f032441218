/* davar tools - noise from a seed, and what most of the trials do not exceed. */
#ifndef DRAW_H
#define DRAW_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static uint64_t draw_state = 1U;

/* Between 0 and 1, neither of them: splitmix64. */
static inline double draw_uniform(void)
{
    draw_state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t z = draw_state;
    z = (z ^ (z >> 30U)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27U)) * UINT64_C(0x94D049BB133111EB);
    return ((double)((z ^ (z >> 31U)) >> 11U) + 0.5) / 9007199254740992.0;
}

/* Standard normal: Box-Muller. */
static inline double draw_gauss(void)
{
    const double radius = sqrt(-2.0 * log(draw_uniform()));
    return radius * cos(6.283185307179586 * draw_uniform());
}

static inline int draw_compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The value that a share of them, 0 to 1, does not exceed; NaN of none. Sorts them. */
static inline double draw_quantile(double values[], size_t count, double share)
{
    qsort(values, count, sizeof values[0], draw_compare);
    return (count > 0U) ? values[(size_t)(share * (double)(count - 1U))] : (double)NAN;
}

#endif
