/* davar tests - the fast path of the fit, in integers, compared with (5.4) to (5.11) in doubles,
 * over random lists, windows and data. */
#include "davar/fit.h"
#include "fit/plan.h"
#include "fit/white.h"
#include "fit_fixture.h"
#include "random.h"

#ifndef TRIALS /* an emulated board runs fewer */
#define TRIALS 2000U
#endif

/* The values of (5.4) to (5.11), in units of N^2 per sample unless stated otherwise. */
typedef struct {
    int count;
    double m[DAVAR_TAUS_MAX];
    double inverse[DAVAR_TAUS_MAX]
                  [DAVAR_TAUS_MAX];   /* of the covariance that weights are made for */
    double effective[DAVAR_TAUS_MAX]; /* differences, mirror images and window ends considered */
    double edf[DAVAR_TAUS_MAX];
    double y[DAVAR_TAUS_MAX];
    double covariance[DAVAR_TAUS_MAX][DAVAR_TAUS_MAX];
    double white; /* N^2 */
    double share[TERMS];
    double variance[TERMS];
    double crowding[TERMS]; /* sum of the absolute parts of the variance over it */
    double centre[TERMS];
    double misfit_over_limit;
    double near_threshold; /* the least distance of a significance from 3 */
    bool explains;
    bool lacks; /* short sizes read low by 3 standard errors */
} expected_t;

static double overlap(double a, double b)
{
    const double e = fmax(0.0, (2.0 * a) - b);
    return (4.0 * a * a * a) + (2.0 * a) - ((4.0 / 3.0) * e * ((e * e) - 1.0));
}

static double shape(const expected_t *e, int term, int t)
{
    const double power[TERMS] = {0, 0, 1, 2, 3};
    return (term == 0) ? (e->m[0] / e->m[t]) : pow(e->m[t] / e->m[e->count - 1], power[term]);
}

/* Inverse by Gauss-Jordan of the covariance in a window of nine longest sizes, with 1e-4 of its
 * diagonal added (5.4). */
static void expect_weights(expected_t *e)
{
    static double a[DAVAR_TAUS_MAX][2 * DAVAR_TAUS_MAX];
    const int n = e->count;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            const double low = fmin(e->m[i], e->m[j]);
            const double s = overlap(low, fmax(e->m[i], e->m[j]));
            const double differences = (9.0 * e->m[n - 1]) + 1.0 - (1.5 * low);
            a[i][j] = s / (2.0 * e->m[i] * e->m[j]) / differences * ((i == j) ? 1.0001 : 1.0);
            a[i][n + j] = (i == j) ? 1.0 : 0.0;
        }
    }
    for (int k = 0; k < n; k++) {
        const double pivot = a[k][k];
        for (int j = 0; j < (2 * n); j++) {
            a[k][j] /= pivot;
        }
        for (int i = 0; i < n; i++) {
            const double factor = (i == k) ? 0.0 : a[i][k];
            for (int j = 0; j < (2 * n); j++) {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    for (int i = 0; i < n; i++) {
        memcpy(e->inverse[i], &a[i][n], (size_t)n * sizeof a[i][0]);
    }
}

static void expect_data(expected_t *e)
{
    const double window = (double)result.window_samples;
    const double evidence = window / (window + (2.0 * (double)result.mirrored_samples));
    e->count = result.tau_count;
    for (int t = 0; t < e->count; t++) {
        const double m = (double)result.tau[t].m;
        const double all = window + 1.0 - (2.0 * m);
        e->m[t] = m;
        e->effective[t] = (all + (0.5 * m)) * ((double)result.tau[t].differences / all) * evidence;
        e->edf[t] = fmax(1.0, 12.0 * m / ((8.0 * m * m) + 10.0) * e->effective[t]);
        e->y[t] = result.tau[t].adev * result.tau[t].adev * m;
    }
}

/* For white noise, between every two cluster sizes. */
static void expect_covariances(expected_t *e)
{
    for (int i = 0; i < e->count; i++) {
        for (int j = i; j < e->count; j++) {
            const double s = overlap(e->m[i], e->m[j]);
            e->covariance[i][j] = s / (2.0 * e->m[i] * e->m[j]) / e->effective[i];
            e->covariance[j][i] = e->covariance[i][j];
        }
    }
}

static double variance_of(const expected_t *e, const double f[], double *size)
{
    double variance = 0.0;
    *size = 0.0;
    for (int i = 0; i < e->count; i++) {
        for (int j = 0; j < e->count; j++) {
            const double part = f[i] * f[j] * e->covariance[i][j];
            variance += part;
            *size += fabs(part);
        }
    }
    return variance;
}

static void expect_term(expected_t *e, int term)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    double f[DAVAR_TAUS_MAX] = {0};
    for (int t = 0; t < e->count; t++) {
        for (int u = 0; u < e->count; u++) {
            sum[0] += e->inverse[t][u];
            sum[1] += e->inverse[t][u] * shape(e, term, u);
        }
    }
    e->centre[term] = (term == WHITE) ? 0.0 : (sum[1] / sum[0]);
    for (int t = 0; t < e->count; t++) {
        for (int u = 0; u < e->count; u++) {
            f[t] += e->inverse[t][u] * (shape(e, term, u) - e->centre[term]);
        }
        sum[2] += f[t] * shape(e, term, t);
    }
    for (int t = 0; t < e->count; t++) {
        f[t] /= sum[2];
        sum[3] += f[t] * e->y[t];
    }
    e->white = (term == WHITE) ? sum[3] : e->white;
    e->share[term] = sum[3] / e->white;
    double size;
    e->variance[term] = variance_of(e, f, &size);
    e->crowding[term] = size / fabs(e->variance[term]);
}

static double misfit_over_limit(const expected_t *e)
{
    double misfit = 0.0;
    double spread = 0.0;
    for (int j = 0; j < e->count; j++) {
        misfit += 0.5 * e->edf[j] * pow((e->y[j] / e->white) - 1.0, 2.0);
        for (int i = 0; i <= j; i++) {
            const double r = overlap(e->m[i], e->m[j]) /
                             sqrt(overlap(e->m[i], e->m[i]) * overlap(e->m[j], e->m[j]));
            spread += ((i < j) ? 4.0 : 2.0) * r * r;
        }
    }
    return misfit / ((double)(e->count - 1) + (5.0 * sqrt(spread)));
}

static void expect(expected_t *e)
{
    static const int order[TERMS] = {WHITE, 0, 2, 3, 4};
    expect_data(e);
    expect_covariances(e);
    expect_weights(e);
    e->near_threshold = 1e9;
    e->explains = true;
    for (int i = 0; i < TERMS; i++) {
        expect_term(e, order[i]);
        if (order[i] != WHITE) {
            const double z = e->share[order[i]] / sqrt(e->variance[order[i]]);
            e->explains = e->explains && !(z > 3.0);
            e->near_threshold = fmin(e->near_threshold, fabs(z - 3.0));
            if (order[i] == DAVAR_QUANTIZATION) {
                e->lacks = (z < -3.0);
                e->near_threshold = fmin(e->near_threshold, fabs(z + 3.0));
            }
        }
    }
    e->misfit_over_limit = misfit_over_limit(e);
    e->explains = e->explains && !e->lacks && (e->misfit_over_limit <= 1.0);
}

/* From the share of a shape to the coefficient in its unit, at one sample per second (1.2). */
static double coefficient(const expected_t *e, int term, double share)
{
    const double last = e->m[e->count - 1];
    const double size[TERMS] = {e->m[0], 1.0, 1.0 / last, 1.0 / (last * last),
                                1.0 / (last * last * last)};
    const double unit[TERMS] = {1.0 / 3.0, 3600.0, 3600.0 * 3600.0 * acos(-1.0) / (2.0 * log(2.0)),
                                3.0 * 216000.0 * 216000.0, 2.0 * 12960000.0 * 12960000.0};
    return sqrt(share * e->white * size[term] * unit[term]);
}

/* (5.11) */
static double upper_bound(const expected_t *e, int term)
{
    const double margin = 1.645 * sqrt(e->variance[term]);
    return coefficient(e, term, (fmax(0.0, e->share[term]) + margin) * (1.0 + margin));
}

/* Lower limit of N^2 over N^2, and whether a small change would move it by a step (5.10). */
static double lower_limit(const expected_t *e, bool *is_at_step)
{
    double least;
    double high;
    davar_chi_square_interval(2.0 / e->variance[WHITE], &least, &high);
    *is_at_step = false;
    for (int k = 0; k < TERMS; k++) {
        const double sigma = sqrt(e->variance[k]);
        const double ratio = e->share[k] / (0.25 * sigma);
        if ((k != WHITE) && (ratio > 0.99)) {
            const double share = e->share[k] + ((k > WHITE) ? (1.5 * sigma) : 0.0);
            const double left = fmax(1e-9, 1.0 - (e->centre[k] * share));
            const double of_term = e->centre[k] * e->centre[k] * e->variance[k];
            const double s = sqrt(0.5 * (e->variance[WHITE] + of_term)) / left;
            double low = 0.0;
            *is_at_step = *is_at_step || (ratio < 1.01) || (fabs(s - 0.36) < 0.01);
            if ((s > 0.0) && (s < 0.36)) {
                davar_chi_square_interval(1.0 / (s * s), &low, &high);
            }
            least = fmin(least, left * low);
        }
    }
    return least;
}

/* ---- data ---- */

/* Ascending: octaves, consecutive, geometric, or random; from 1 or above. */
static uint8_t any_list(random_t *random, uint32_t window, uint32_t m[])
{
    const uint64_t kind = random_next(random) % 4U;
    const uint64_t most = 1U + (random_next(random) % DAVAR_TAUS_MAX);
    uint64_t size = ((random_next(random) % 2U) == 0U)
                        ? 1U
                        : (1U + (random_next(random) % (1U + (window / 20U))));
    uint8_t count = 0U;
    while ((count < most) && ((2U * size) <= window)) {
        const uint64_t steps[] = {size, 1U + (random_next(random) % 3U), 1U + (size / 3U),
                                  1U + (random_next(random) % 100U)};
        m[count++] = (uint32_t)size;
        size += steps[kind];
    }
    return count;
}

/* White noise with the scatter of Allan variances, one draw for sizes that are nearly equal; drift:
 * some K or Q added. */
static void draw(random_t *random, double drift)
{
    const double size = pow(10.0, (20.0 * random_uniform(random)) - 10.0);
    double scatter = 0.0;
    for (int t = 0; t < result.tau_count; t++) {
        const double m = (double)result.tau[t].m;
        const double edf = fmax(1.0, 1.5 * (double)result.tau[t].differences / m);
        if ((t == 0) || (m > (1.2 * (double)result.tau[t - 1].m))) {
            scatter = random_gauss(random);
        }
        const double white = fmax(0.02, 1.0 + (0.7 * scatter * sqrt(2.0 / edf)));
        const double walk = (drift > 0.0) ? (drift * m * m) : (-drift / m);
        result.tau[t].adev = size * sqrt((white + walk) / m);
    }
}

static bool any_window(random_t *random)
{
    uint32_t m[DAVAR_TAUS_MAX];
    const uint32_t window = (uint32_t)pow(2.0, 4.0 + (18.0 * random_uniform(random)));
    const uint8_t count = any_list(random, window, m);
    memset(&result, 0, sizeof result);
    if (count < 2U) {
        return false; /* the rest is outside this test: test_fit.c */
    }
    set_taus(window, m, count);
    result.mirrored_samples =
        ((random_next(random) % 4U) == 0U) ? (uint32_t)(random_next(random) % (window / 2U)) : 0U;
    const double left = ((random_next(random) % 4U) == 0U) ? random_uniform(random) : 1.0;
    for (int t = 0; t < count; t++) {
        result.tau[t].differences = (uint32_t)ceil(left * (double)result.tau[t].differences);
    }
    const double strength = pow(10.0, 4.0 - (8.0 * random_uniform(random)));
    const double last = (double)m[count - 1U];
    const double drifts[] = {0.0, 0.0, strength / (last * last), -strength};
    draw(random, drifts[random_next(random) % 4U]);
    return true;
}

/* ---- the tests ---- */

static void assert_reported(const expected_t *e)
{
    bool is_at_step;
    double low;
    double high;
    const double least = lower_limit(e, &is_at_step);
    const double white = coefficient(e, WHITE, 1.0);
    davar_chi_square_interval(2.0 / e->variance[WHITE], &low, &high);
    assert_near(white, term(DAVAR_ANGLE_RANDOM_WALK)->value, 1e-5);
    assert_near(white * sqrt(high), term(DAVAR_ANGLE_RANDOM_WALK)->high, 1e-4);
    if (!is_at_step) {
        TEST_ASSERT_DOUBLE_WITHIN(0.003 * white, white * sqrt(least),
                                  term(DAVAR_ANGLE_RANDOM_WALK)->low);
    }
    for (int t = 0; t < e->count; t++) {
        davar_chi_square_interval(e->edf[t], &low, &high);
        assert_near(e->edf[t], result.tau[t].edf, 1e-5);
        assert_near(result.tau[t].adev * sqrt(low), result.tau[t].low, 1e-5);
        assert_near(result.tau[t].adev * sqrt(high), result.tau[t].high, 1e-5);
    }
}

/* Of any size, also with a drift far above the white noise. */
static void assert_shares(const expected_t *e, const davar_white_t *white)
{
    for (int k = 0; k < TERMS; k++) {
        const double share = fmax(0.0, e->share[k]);
        if ((k != WHITE) && (e->crowding[k] < 1e3) && (share < (1000.0 * (double)plan.scale[k]))) {
            const double found = (double)white->share[k] / (double)(1U << DAVAR_FIT_SHARE_BITS) *
                                 (double)plan.scale[k];
            TEST_ASSERT_DOUBLE_WITHIN((1e-3 * share) + (0.01 * sqrt(e->variance[k])), share, found);
        }
    }
}

static void assert_bounds(const expected_t *e)
{
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && (e->crowding[k] < 1e3)) { /* not the difference of nearly equal sums */
            if (e->variance[k] > 0.0) {
                assert_near(upper_bound(e, k), result.coefficient[k].high, 2e-3);
            } else { /* (5.3) does not hold for so short a window: nothing is known */
                TEST_ASSERT_TRUE(isinf(result.coefficient[k].high));
            }
        }
    }
}

static void test_white_noise_or_not_is_decided_as_in_doubles(void)
{
    random_t random = random_seeded(21U);
    unsigned white_noise = 0U;
    unsigned other = 0U;
    for (unsigned trial = 0U; trial < TRIALS; trial++) {
        expected_t e = {0};
        davar_white_t white = {.suspects = 0U};
        if (any_window(&random)) {
            expect(&e);
            davar_fit(&plan, 1.0, &result);
            const bool suffices = davar_white_suffices(&plan, 1.0, &result, &white);
            const bool found = suffices && (result.noise == DAVAR_NOISE_WHITE);
            TEST_ASSERT_EQUAL_INT(suffices, found || (result.noise == DAVAR_NOISE_FILTERED));
            assert_shares(&e, &white);
            if ((e.near_threshold > 0.01) && (fabs(e.misfit_over_limit - 1.0) > 0.01)) {
                TEST_ASSERT_EQUAL_INT(e.explains, found);
            }
            if (e.explains && found) {
                assert_reported(&e);
                assert_bounds(&e);
            }
            white_noise += e.explains ? 1U : 0U;
            other += e.explains ? 0U : 1U;
        }
    }
    TEST_ASSERT_TRUE((white_noise > (TRIALS / 4U)) &&
                     (other > (TRIALS / 10U))); /* both cases occurred */
}

/* One Allan variance that no mix of terms gives, ten standard errors off or less: the limit of
 * (5.9) is where the formula puts it. */
static void test_the_misfit_is_where_the_formula_puts_it(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};
    unsigned kept = 0U;
    for (int step = 0; step < 60; step++) {
        expected_t e = {0};
        davar_white_t white = {.suspects = 0U};
        memset(&result, 0, sizeof result);
        set_taus(600U, m, 7U);
        for (int t = 0; t < 7; t++) {
            const double sign = (t % 2 == 0) ? 1.0 : -1.0; /* alternating: like no term */
            result.tau[t].adev =
                sqrt((1.0 + (sign * 0.1 * step * sqrt(2.0 * (double)m[t] / 900.0))) / (double)m[t]);
            result.tau[t].adev = (result.tau[t].adev > 0.0) ? result.tau[t].adev : 0.01;
        }
        expect(&e);
        davar_fit(&plan, 1.0, &result);
        const bool suffices = davar_white_suffices(&plan, 1.0, &result, &white);
        const bool found = suffices && (result.noise == DAVAR_NOISE_WHITE);
        TEST_ASSERT_EQUAL_INT(suffices, found || (result.noise == DAVAR_NOISE_FILTERED));
        if ((e.near_threshold > 0.01) && (fabs(e.misfit_over_limit - 1.0) > 0.01)) {
            TEST_ASSERT_EQUAL_INT(e.explains, found);
        }
        kept += e.explains ? 1U : 0U;
    }
    TEST_ASSERT_TRUE((kept > 5U) && (kept < 55U));
}

/* A precomputed plan gives the same bits if the window supports every size that it has. */
static void test_a_precomputed_plan_gives_the_same_result(void)
{
    random_t random = random_seeded(5U);
    unsigned white_noise = 0U;
    unsigned other = 0U;
    for (unsigned trial = 0U; trial < TRIALS; trial++) {
        if (any_window(&random)) {
            davar_plan_t ready;
            davar_result_t again = result;
            (void)davar_fit_white(&plan, 1.0, &result);
            memcpy(&ready, &plan, sizeof ready);
            ready.white.window = 0U;
            TEST_ASSERT_EQUAL_INT(result.noise == DAVAR_NOISE_WHITE,
                                  davar_fit_white_ready(&ready, 1.0, &again));
            TEST_ASSERT_EQUAL_MEMORY(&result, &again, sizeof result);
            white_noise += (result.noise == DAVAR_NOISE_WHITE) ? 1U : 0U;
            other += (result.noise == DAVAR_NOISE_MIXED) ? 1U : 0U;
        }
    }
    TEST_ASSERT_TRUE((white_noise > (TRIALS / 4U)) &&
                     (other > (TRIALS / 10U))); /* both cases occurred */
}

/* Gaps can leave the longest sizes without a difference. The others then stand in for them: as the
 * solved plan of fewer sizes, whose weights hardly differ. */
static void test_sizes_without_differences_are_left_out(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};
    random_t random = random_seeded(9U);
    for (uint8_t left = 7U; left > 0U; left--) {
        for (unsigned trial = 0U; trial < 50U; trial++) {
            davar_plan_t ready;
            set_taus(600U, m, 7U);
            davar_plan_init(&ready, m, 7U);
            davar_plan_init(&plan, m, 7U);
            for (uint8_t t = 0U; t < 7U; t++) {
                const double scatter = 0.03 * sqrt((double)m[t]) * (random_uniform(&random) - 0.5);
                result.tau[t].adev = sqrt((1.0 + scatter) / (double)m[t]);
                result.tau[t].differences = (t < left) ? (result.tau[t].differences / 2U) : 0U;
            }
            davar_result_t again = result;
            (void)davar_fit_white(&plan, 1.0, &result);
            (void)davar_fit_white_ready(&ready, 1.0, &again);
            const davar_coefficient_t *const found = &again.coefficient[WHITE];
            const davar_coefficient_t *const solved = &result.coefficient[WHITE];
            TEST_ASSERT_EQUAL_INT((left >= 3U) ? DAVAR_NOISE_WHITE : DAVAR_NOISE_UNKNOWN,
                                  again.noise);
            TEST_ASSERT_EQUAL(left >= 3U, found->present);
            if (found->present) {
                TEST_ASSERT_DOUBLE_WITHIN(0.01 * solved->value, solved->value, found->value);
                /* without the longest sizes, a drift is in doubt a little earlier */
                TEST_ASSERT_DOUBLE_WITHIN(0.1 * solved->value, solved->low, found->low);
                TEST_ASSERT_DOUBLE_WITHIN(0.05 * solved->value, solved->high, found->high);
                TEST_ASSERT_TRUE((left == 7U) || isnan(again.tau[left].low));
            }
        }
    }
}

/* What stands in is bounded, and needs half of the weight. */
static void test_few_sizes_do_not_stand_in_for_the_weight(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};
    for (int vague = 0; vague < 2; vague++) {
        davar_filter_t filter = {.b = {0.0}};
        if (vague != 0) {
            davar_filter_low_pass(&filter, 0.05, 1U, 0.5);
        } else {
            davar_filter_biquad(&filter, 0.05);
        }
        set_taus(600U, m, 7U);
        davar_plan_init_filtered(&plan, m, 7U, &filter);
        for (uint8_t t = 0U; t < 7U; t++) {
            result.tau[t].adev = (t == 0U) ? 1e6 : 1e-6;
            result.tau[t].differences = (t < 3U) ? result.tau[t].differences : 0U;
        }
        (void)davar_fit_white_ready(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(vague != 0, result.noise == DAVAR_NOISE_UNKNOWN);
        TEST_ASSERT_FALSE(result.coefficient[WHITE].present);
    }
}

static void test_a_window_without_a_difference_gives_no_values(void)
{
    static const uint32_t m[] = {1U, 2U, 4U};
    set_taus(8U, m, 3U);
    result.tau[0].differences = 0U;
    (void)davar_fit_white(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_UNKNOWN, result.noise);
    TEST_ASSERT_FALSE(result.coefficient[WHITE].present);
    result.tau_count = 0U;
    (void)davar_fit_white(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(isinf(result.coefficient[WHITE].high));
    (void)davar_fit_white_ready(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_UNKNOWN, result.noise);
    TEST_ASSERT_TRUE(isinf(result.coefficient[WHITE].high));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_or_not_is_decided_as_in_doubles);
    RUN_TEST(test_the_misfit_is_where_the_formula_puts_it);
    RUN_TEST(test_a_precomputed_plan_gives_the_same_result);
    RUN_TEST(test_sizes_without_differences_are_left_out);
    RUN_TEST(test_few_sizes_do_not_stand_in_for_the_weight);
    RUN_TEST(test_a_window_without_a_difference_gives_no_values);
    return UNITY_END();
}
