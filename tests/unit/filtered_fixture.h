/* davar tests - filters, and the exact Allan variances of noise after one of them. */
#ifndef DAVAR_TESTS_FILTERED_FIXTURE_H
#define DAVAR_TESTS_FILTERED_FIXTURE_H

#include "fit/plan.h"
#include "fit_fixture.h"
#include "shape.h"

#define SIZES 7
#define WINDOW 600U

static const shape_t filters[] = {
    {0},
    {.cutoff = 0.05, .poles = 1U},
    {.cutoff = 0.25, .poles = 1U, .uncertainty = 0.1},
    {.cutoff = 0.05, .poles = 2U},
    {.cutoff = 0.1, .poles = 2U, .uncertainty = 0.1},
    {.cutoff = 0.25, .poles = 2U},
    {.cutoff = 0.45, .poles = 2U, .uncertainty = 0.2},
    {.averages = 3U, .length = 64U, .decimation = 64U},
    {.averages = 1U, .length = 8U},
};
#define FILTERS (sizeof filters / sizeof filters[0])

static inline void plan_filter(const shape_t *filter)
{
    uint32_t m[SIZES];
    set_octaves(WINDOW, SIZES);
    for (int t = 0; t < SIZES; t++) {
        m[t] = result.tau[t].m;
    }
    if (filter != NULL) {
        plan_shape(&plan, m, SIZES, filter);
    } else {
        davar_plan_init(&plan, m, SIZES);
    }
}

/* The Allan variances of a mix after a filter, rounded to counts. */
static inline void set_filtered(const shape_t *filter, const double a[], double count)
{
    static davar_plan_t truth;
    uint32_t m[SIZES];
    for (int t = 0; t < SIZES; t++) {
        m[t] = result.tau[t].m;
    }
    plan_shape(&truth, m, SIZES, filter);
    result.unit_per_count = count;
    for (int t = 0; t < SIZES; t++) {
        const double size = (double)m[t];
        const double mix[] = {a[0], (a[1] * (double)truth.gain[t]) + (count * count / 12.0),
                              a[2] * pow((double)truth.flicker[t], 2.0),
                              a[3] * pow((double)truth.walk[t], 2.0), a[4]};
        result.tau[t].adev = sqrt(avar_at(mix, size));
    }
}

static inline double arw_of(double white)
{
    return 60.0 * sqrt(white);
}

static inline double dot_terms(const double a[], const double b[])
{
    double sum = 0.0;
    for (int k = 0; k < TERMS; k++) {
        sum += a[k] * b[k];
    }
    return sum;
}

#endif
