/* davar tests - one result, the plan of its cluster sizes, and Allan variances of an exact mix of
 * noise terms. Every function is static and inline: each suite uses those that it needs. */
#ifndef DAVAR_TESTS_FIT_FIXTURE_H
#define DAVAR_TESTS_FIT_FIXTURE_H

#include "davar/fit.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static davar_plan_t plan;
static davar_result_t result;

void setUp(void)
{
    memset(&plan, 0, sizeof plan);
    memset(&result, 0, sizeof result);
}

void tearDown(void) {}

/* The Allan variance of a mix in sample units, a[k] m^(k - 2), DESIGN (1.2). */
static inline double avar_at(const double a[], double m)
{
    return a[0] / (m * m) + a[1] / m + a[2] + a[3] * m + a[4] * m * m;
}

static inline void set_taus(uint32_t window, const uint32_t *m, uint8_t count)
{
    result.window_samples = window;
    result.tau_count = count;
    for (int t = 0; t < count; t++) {
        result.tau[t].m = m[t];
        result.tau[t].differences = (2U * m[t] <= window) ? window - 2U * m[t] + 1U : 0U;
    }
    davar_plan_init_white(&plan, m, count);
}

static inline void set_octaves(uint32_t window, uint8_t count)
{
    uint32_t m[DAVAR_TAUS_MAX];
    for (int t = 0; t < count; t++) {
        m[t] = UINT32_C(1) << (unsigned)t;
    }
    set_taus(window, m, count);
}

static inline void set_model(const double a[])
{
    for (int t = 0; t < result.tau_count; t++) {
        result.tau[t].adev = sqrt(avar_at(a, result.tau[t].m));
    }
}

static inline void assert_near(double expected, double actual, double relative)
{
    TEST_ASSERT_DOUBLE_WITHIN(relative * fabs(expected), expected, actual);
}

static inline const davar_coefficient_t *term(davar_coefficient_kind_t kind)
{
    return &result.coefficient[kind];
}

static inline unsigned present_terms(void)
{
    unsigned found = 0U;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        found |= (result.coefficient[k].present ? 1U : 0U) << (unsigned)k;
    }
    return found;
}

static inline void assert_holds(double truth, const davar_coefficient_t *c)
{
    TEST_ASSERT_TRUE(c->present);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * truth, truth, c->value);
    TEST_ASSERT_TRUE(c->low < truth);
    TEST_ASSERT_TRUE(c->high > truth);
}

static inline void assert_absent_below(double bound, const davar_coefficient_t *c)
{
    TEST_ASSERT_FALSE(c->present);
    TEST_ASSERT_TRUE(isnan(c->value));
    TEST_ASSERT_TRUE(isnan(c->low));
    TEST_ASSERT_TRUE(c->high <= bound);
}

#endif
