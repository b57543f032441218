/* davar tests - the plan of a fit for filtered noise (5.16), compared with brute force: sums over the
 * autocovariance of the filtered noise, and an integral over the spectrum of a drift. */
#include "autocovariance.h"
#include "davar/davar.h"
#include "fit/plan.h"
#include "fit_fixture.h"
#include "random.h"

#include <math.h>
#include <stdlib.h>

#define PI AUTOCOVARIANCE_PI
#define SPAN ((2 * AUTOCOVARIANCE_LAGS) + 512)

static const shape_t filters[] = {
    {0}, /* white */
    {.cutoff = 0.05, .poles = 1U},
    {.cutoff = 0.25, .poles = 1U},
    {.cutoff = 0.05, .poles = 2U},
    {.cutoff = 0.1, .poles = 2U, .uncertainty = 0.1},
    {.cutoff = 0.25, .poles = 2U},
    {.cutoff = 0.45, .poles = 2U, .decimation = 1U},
    {.averages = 3U, .length = 64U, .decimation = 64U}, /* CIC */
    {.averages = 1U, .length = 2U},
    {.averages = 1U, .length = 8U},
    {.averages = 1U, .length = 8U, .decimation = 8U}, /* mean of blocks */
    {.cutoff = 0.1, .poles = 2U, .averages = 2U, .length = 4U, .decimation = 4U},
    {.cutoff = 0.3, .poles = 1U, .averages = 1U, .length = 3U, .decimation = 3U},
    {.cutoff = 0.01, .poles = 2U},
    {.cutoff = 1.9, .poles = 2U},
    {.averages = 1U, .length = 300U},
    {.averages = 8U, .length = 7U},
    {.cutoff = 0.2, .poles = 1U, .averages = 1U, .length = 60U},
    {.cutoff = 0.1, .poles = 2U, .averages = 3U, .length = 4U},
    {SHAPE_SUM(8U)},
    {SHAPE_LOW_PASS(250, 1000, 2), SHAPE_SUM(8U)},
};
#define FILTERS (sizeof filters / sizeof filters[0])

static const uint32_t sizes[] = {1U, 2U, 3U, 5U, 8U, 16U, 64U};
#define SIZES 7

/* ---- brute force: autocovariances ---- */

static autocovariance_t of_noise;

static void set_autocovariance(const shape_t *filter, double cutoff)
{
    shape_t moved = *filter;
    moved.cutoff = cutoff;
    autocovariance_of(&moved, &of_noise);
}

static double r_at(int lag)
{
    const int k = (lag < 0) ? -lag : lag;
    return (k < of_noise.count) ? of_noise.r[k] : 0.0;
}

/* m avar of the filtered noise. */
static double expected_gain(int m)
{
    double sum = 2.0 * m * r_at(0);
    for (int k = 1; k < 2 * m; k++) {
        sum += 2.0 * r_at(k) * ((k <= m) ? (2.0 * m - 3.0 * k) : (k - 2.0 * m));
    }
    return sum / (2.0 * m);
}

/* Sum over all lags of the squared covariance of two differences, of which `more` is white. */
static double squared_covariances(int m_t, int m_u, double more)
{
    static double half[SPAN];
    const int middle = of_noise.count + (2 * m_t);
    const int count = middle + of_noise.count + (2 * m_u);
    double sum = 0.0;
    TEST_ASSERT_TRUE(count < SPAN);
    for (int lag = 0; lag < count; lag++) {
        half[lag] = 0.0;
        for (int i = 0; i < 2 * m_t; i++) {
            const int at = lag - middle + i;
            half[lag] += ((i < m_t) ? -1.0 : 1.0) * (r_at(at) + ((at == 0) ? more : 0.0));
        }
    }
    for (int lag = 1 - (2 * m_u); lag < count; lag++) {
        double both = 0.0;
        for (int j = 0; j < 2 * m_u; j++) {
            const int at = lag + j;
            both += ((at >= 0) && (at < count)) ? (((j < m_u) ? -1.0 : 1.0) * half[at]) : 0.0;
        }
        sum += both * both;
    }
    return sum;
}

static void plan_filter(const shape_t *filter)
{
    memset(&plan, 0xA5, sizeof plan);
    plan_shape(&plan, sizes, SIZES, filter);
    set_autocovariance(filter, filter->cutoff);
}

/* Of what is rounded to counts: the samples, or what davar_average adds. */
static void set_counts_autocovariance(const shape_t *filter)
{
    shape_t counts = *filter;
    if (filter->summed > 1U) {
        counts.averages = 0U;
        counts.decimation = 1U;
        counts.cutoff = filter->cutoff / (double)filter->summed;
    }
    set_autocovariance(&counts, counts.cutoff);
}

/* ---- white noise ---- */

static void test_gains_match_the_autocovariance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        for (int t = 0; t < SIZES; t++) {
            assert_near(expected_gain((int)sizes[t]), (double)plan.gain[t], 2e-6);
        }
        TEST_ASSERT_EQUAL_HEX32(0U, davar_bits_of_float(plan.gain[SIZES])); /* no further size */
    }
}

static void test_covariances_match_the_autocovariance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        set_counts_autocovariance(&filters[f]);
        /* A sample scatters by six counts; the plan of white samples has no rounding in it. */
        const bool is_white = (f == 0U) || (f == 10U);
        const double floor = is_white ? 0.0 : r_at(0) / (12.0 * 6.0 * 6.0);
        plan_filter(&filters[f]);
        TEST_ASSERT_EQUAL(is_white, !(plan.white.step > 0.0F));
        assert_near(floor, (double)plan.floor, 1e-5);
        for (int u = 0; u < SIZES; u++) {
            for (int t = 0; t <= u; t++) {
                const int m_t = (int)sizes[t];
                const int m_u = (int)sizes[u];
                const double gains = (double)plan.gain[t] * (double)plan.gain[u];
                const double expected =
                    squared_covariances(m_t, m_u, floor) / (2.0 * m_t * m_u) / gains;
                assert_near(expected, (double)plan.covariance[plan_pair(t, u)], 2e-5);
            }
        }
    }
}

/* The variance of a sample, and the noise below which rounding hides it: a sample of half a count,
 * or a step that is too small (5.15). */
static void test_a_sample_matches_the_autocovariance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        set_counts_autocovariance(&filters[f]);
        const double by_sample = r_at(0) / 3.0;
        const double by_step = (r_at(0) - r_at(1)) * 25.0 / 6.0;
        const double summed = (filters[f].summed > 1U) ? (double)filters[f].summed : 1.0;
        assert_near(r_at(0), (double)plan.white.sample, 1e-5);
        assert_near(sqrt(summed / (12.0 * fmin(by_sample, by_step))), (double)plan.white.hidden,
                    1e-5);
        assert_near(summed / 12.0, plan.white.rounding_variance, 1e-15);
    }
}

/* m avar of the filtered noise, from a spectrum whose frequency axis is stretched. */
static double stretched_gain(int m, double stretch)
{
    enum { POINTS = 1024 };
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const double angle = (i + 0.5) * PI / POINTS;
        double s = r_at(0);
        for (int k = 1; k < of_noise.count; k++) {
            s += 2.0 * r_at(k) * cos(k * angle / stretch);
        }
        sum += s * 2.0 * pow(sin(0.5 * m * angle), 4.0) / (m * pow(sin(0.5 * angle), 2.0));
    }
    return sum / POINTS;
}

/* Of an analogue low-pass alone, the cutoff changes; of other coefficients, the frequency axis. Moving
 * averages that are no coefficients are exact. */
static double changed_gain(const shape_t *shape, const davar_filter_t *filter, int m, double factor)
{
    if (shape->averages == 0U) {
        set_autocovariance(shape, shape->cutoff * factor);
        return expected_gain(m);
    }
    set_autocovariance(shape, shape->cutoff);
    return stretched_gain(m, (filter->averages > 0U) ? 1.0 : factor);
}

/* The relative change of a gain by one standard error of the cutoff: of one pole exact, of two
 * within 12 %, and within 30 % near half the rate, where it changes little. */
static void test_offsets_are_derivatives_by_the_frequency(void)
{
    static const double near[] = {0.015, 0.015, 0.12};
    for (size_t f = 0; f < FILTERS; f++) {
        shape_t shape = filters[f];
        shape.uncertainty = 0.1;
        const davar_filter_t filter = filter_of(&shape);
        const bool has_pole_alone = (shape.poles == 1U) && (filter.averages > 0U);
        davar_plan_init_filtered(&plan, sizes, SIZES, &filter);
        for (int t = 0; (t < SIZES) && !has_pole_alone && (shape.cutoff < 1.0); t++) {
            const double above = changed_gain(&shape, &filter, (int)sizes[t], 1.05);
            const double below = changed_gain(&shape, &filter, (int)sizes[t], 1.0 / 1.05);
            const double by_axis = (shape.averages > 0U) ? filter.uncertainty : 0.1;
            const double expected = by_axis * log(above / below) / (2.0 * log(1.05));
            const double part = (shape.cutoff > 0.4) ? 0.3 : near[shape.poles];
            TEST_ASSERT_DOUBLE_WITHIN((part * fabs(expected)) + 2e-4, expected,
                                      (double)plan.offset[t]);
        }
    }
}

/* What the level is not known to, adds to the variance of the angle random walk. */
static void test_the_level_of_a_learned_filter_widens_the_interval(void)
{
    davar_filter_t filter = filter_of(&filters[4]);
    filter.uncertainty = 0.0;
    davar_plan_init_filtered(&plan, sizes, SIZES, &filter);
    TEST_ASSERT_EQUAL_FLOAT(0.0F, plan.offset_variance[WHITE]);
    filter.level = 0.03;
    davar_plan_init_filtered(&plan, sizes, SIZES, &filter);
    assert_near(0.06 * 0.06, (double)plan.offset_variance[WHITE], 1e-6);
}

/* ---- drifts ---- */

/* Power gain of the complete filter at an angle of the sampled spectrum, aliases not folded. */
static double power_gain(const shape_t *filter, double angle)
{
    const double ratio = angle / (2.0 * PI * filter->cutoff);
    const double low = (filter->poles == 0U)   ? 1.0
                       : (filter->poles == 1U) ? (1.0 / (1.0 + (ratio * ratio)))
                                               : (1.0 / (1.0 + pow(ratio, 4.0)));
    const double half = 0.5 * angle / shape_decimation(filter);
    const double length = (double)filter->length;
    const double average =
        (filter->averages > 0U) ? (sin(length * half) / (length * sin(half))) : 1.0;
    return low * pow(average * average, (double)filter->averages);
}

/* m avar of a drift whose spectrum is 1 / angle^power, by the midpoint rule. */
static double drift_avar(const shape_t *filter, double m, int power)
{
    const double step = PI / 1024.0;
    double sum = 0.0;
    for (int i = 0; i < (64 * 1024); i++) {
        const double angle = (i + 0.5) * step;
        const double sine = sin(0.5 * angle);
        const double kernel = 2.0 * pow(sin(0.5 * m * angle), 4.0) / (m * sine * sine);
        sum += kernel * power_gain(filter, angle) / pow(angle, power);
    }
    return sum * step / PI;
}

/* The plan treats what is aliased as a drift in the base band: exact at long sizes, too much at the
 * shortest by less than this share. The midpoint rule of the plan errs by 1 %. */
static void test_drifts_pass_the_filter_as_their_spectrum_does(void)
{
    static const struct {
        size_t filter;
        double at_one;
    } most[] = {{1, 0.1},  {2, 0.1},   {3, 0.001},  {4, 0.003}, {5, 0.02},  {6, 0.04},
                {7, 0.01}, {10, 0.16}, {11, 0.001}, {12, 0.08}, {13, 0.001}};
    for (size_t i = 0; i < sizeof most / sizeof most[0]; i++) {
        const shape_t *const filter = &filters[most[i].filter];
        plan_filter(filter);
        for (int t = 0; t < SIZES; t++) {
            const double m = (double)sizes[t];
            const double more = most[i].at_one / m;
            const double flicker = drift_avar(filter, m, 1) / (2.0 * log(2.0) / PI * m);
            const double walk = drift_avar(filter, m, 2) * 3.0 / (m * m);
            assert_near(flicker, pow((double)plan.flicker[t], 2.0), 0.01 + more);
            assert_near(walk, pow((double)plan.walk[t], 2.0), 0.001 + more);
        }
    }
}

/* ---- the spectrum, and long sizes ---- */

/* The spectrum as the sum over the autocovariance. */
static double spectrum_at(double frequency)
{
    double sum = of_noise.r[0];
    for (int lag = 1; lag < of_noise.count; lag++) {
        sum += 2.0 * of_noise.r[lag] * cos(2.0 * PI * frequency * lag);
    }
    return sum;
}

static void test_the_power_gain_matches_the_autocovariance(void)
{
    for (size_t f = 0U; f < FILTERS; f++) {
        autocovariance_of(&filters[f], &of_noise);
        const davar_filter_t filter = filter_of(&filters[f]);
        TEST_ASSERT_TRUE(davar_filter_is_valid(&filter));
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1.0, davar_filter_power(&filter, 0.0));
        for (int i = 1; i <= 10; i++) {
            const double frequency = 0.05 * i;
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, spectrum_at(frequency),
                                      davar_filter_power(&filter, frequency));
        }
    }
}

static void test_sizes_beyond_the_filter_are_white(void)
{
    static const uint32_t m[] = {16U, 4096U, 4097U, 100000U, 150000U, 16777216U};
    const shape_t filter = {.cutoff = 0.01, .poles = 2U};
    set_autocovariance(&filter, filter.cutoff);
    plan_shape(&plan, m, 6U, &filter);
    for (int u = 0; u < 6; u++) {
        if (m[u] <= 150000U) {
            assert_near(expected_gain((int)m[u]), (double)plan.gain[u], 2e-6);
        }
        for (int t = 0; (t <= u) && (u > 1); t++) {
            const double both = 2.0 * (double)m[t] * (double)m[u];
            assert_near(davar_noise_white_overlap((double)m[t], (double)m[u]) / both,
                        (double)plan.covariance[plan_pair(t, u)], 1e-6);
        }
    }
    TEST_ASSERT_TRUE((plan.gain[4] > 0.9998F) && (plan.gain[5] > plan.gain[4]));
    TEST_ASSERT_TRUE(plan.gain[5] <= 1.0F);
    TEST_ASSERT_EQUAL_FLOAT(1.0F, plan.flicker[5]);
    TEST_ASSERT_EQUAL_FLOAT(1.0F, plan.walk[5]);
    plan_shape(&plan, &m[2], 2U, &filter); /* none within the filter */
    TEST_ASSERT_EQUAL_FLOAT(1.0F, plan.gain[0]);
    TEST_ASSERT_EQUAL_FLOAT(1.0F, plan.gain[1]);
    assert_near(r_at(0), (double)plan.white.sample, 1e-5);
}

/* Sum of a functional over the sizes: 1 for white noise, 0 for each other term. */
static double sum_of_functional(int term, uint8_t count)
{
    double sum = 0.0;
    for (uint8_t t = 0U; t < count; t++) {
        const double value = (double)plan.white.functional[term][t] / DAVAR_FIT_FUNCTIONAL_ONE;
        TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, value);
        sum += value;
    }
    return sum;
}

/* Above m = 4096, the covariance is that of white samples. After averages twice to four times as
 * long, it was none, and such plans were NaN. */
static void test_plans_of_the_longest_averages_are_plans(void)
{
    random_t random = random_seeded(5U);
    for (uint32_t trial = 0U; trial < 400U; trial++) {
        uint32_t m[DAVAR_TAUS_MAX];
        uint8_t count = 0U;
        for (uint32_t next = 1U + (trial % 64U); (count < DAVAR_TAUS_MAX) && (next < 10000000U);) {
            m[count] = next;
            count++;
            next += 1U + ((trial % 2U == 0U) ? (uint32_t)(random_next(&random) % next) : next);
        }
        shape_t filter = {.averages = (uint8_t)(1U + ((trial / 3U) % 2U)), .cutoff = 0.004};
        filter.length = (uint16_t)(DAVAR_FILTER_SPAN / filter.averages);
        filter.poles = (uint8_t)(trial % 3U);
        plan_shape(&plan, m, count, &filter);
        TEST_ASSERT_TRUE(isfinite(plan.white.rounding));
        for (int k = 0; k < TERMS; k++) {
            TEST_ASSERT_TRUE(isfinite(plan.offset_variance[k]));
            const double unit = (k == WHITE) ? ldexp(1.0, plan.white.white_bits) : 1.0;
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * unit, (k == WHITE) ? 1.0 : 0.0,
                                      unit * sum_of_functional(k, count));
        }
    }
}

static void test_the_inverse_of_a_gain_saturates(void)
{
    static const uint32_t m[] = {1U, 4096U};
    const shape_t narrow = {.averages = 8U, .length = 128U};
    plan_shape(&plan, m, 2U, &narrow);
    TEST_ASSERT_TRUE(plan.gain[0] < 1e-7F);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, plan.white.inverse_gain[0]);
}

/* ---- the laws of the window ---- */

#define BLOCK 10 /* samples, the default */

/* White noise before the filter over the whitened samples about the mean of their block. */
static double level_after(const double h[3])
{
    double rest = 0.0;
    for (int k = 0; k < BLOCK; k++) {
        for (int l = 0; l < BLOCK; l++) {
            const double weight = ((k == l) ? 1.0 : 0.0) - (1.0 / BLOCK);
            for (int i = 0; i < 9; i++) {
                rest +=
                    weight * h[i / 3] * h[i % 3] * r_at(k - l + (i / 3) - (i % 3)) / (BLOCK - 1.0);
            }
        }
    }
    return 1.0 / sqrt(rest);
}

/* Yule-Walker with rounding of a sample that scatters by six counts. */
static void test_whitening_matches_the_autocovariance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        davar_config_t config = davar_default_config;
        set_autocovariance(&filters[f], filters[f].cutoff);
        whiten_shape(&config, &filters[f]);
        const double r0 = r_at(0) * (1.0 + (1.0 / 432.0));
        const double determinant = (r0 * r0) - (r_at(1) * r_at(1));
        const double first = ((r0 * r_at(1)) - (r_at(1) * r_at(2))) / determinant;
        const double second = ((r0 * r_at(2)) - (r_at(1) * r_at(1))) / determinant;
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 16384.0 * first, config.glr.whiten_first);
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 16384.0 * second, config.glr.whiten_second);
        const double h[3] = {1.0, -config.glr.whiten_first / 16384.0,
                             -config.glr.whiten_second / 16384.0};
        assert_near(level_after(h), config.glr.whiten_level, 1e-6);
    }
}

/* The level after a filter whose cutoff is one standard uncertainty higher. */
static void test_the_tolerance_is_that_of_the_cutoff(void)
{
    static const double cutoffs[] = {0.05, 0.1, 0.25};
    for (int poles = 1; poles <= 2; poles++) {
        for (int i = 0; i < 3; i++) {
            davar_config_t config = davar_default_config;
            const shape_t declared = {
                .cutoff = cutoffs[i], .poles = (uint8_t)poles, .uncertainty = 0.02};
            whiten_shape(&config, &declared);
            const double h[3] = {1.0, -config.glr.whiten_first / 16384.0,
                                 -config.glr.whiten_second / 16384.0};
            double level[2];
            for (int k = 0; k < 2; k++) {
                const double factor = (k == 0) ? 0.98 : 1.02;
                set_autocovariance(&declared, factor * cutoffs[i]);
                level[k] = level_after(h);
            }
            /* of two poles, the frequency axis is stretched, not the analogue cutoff */
            assert_near(1.96 * 0.5 * fabs(level[0] - level[1]) / config.glr.whiten_level,
                        config.glr.whiten_tolerance, (poles == 1) ? 0.01 : 0.15);
        }
    }
}

/* Upper quantiles of the normal distribution, from tables. */
static const struct {
    double rate;
    double each;  /* of a criterion that has half of the rate */
    double alone; /* ... the whole rate */
} quantiles[] = {{0.1, 1.959963985, 1.644853627},
                 {0.01, 2.807033768, 2.575829304},
                 {0.001, 3.480756404, 3.290526731},
                 {0.0001, 4.055626981, 3.890591886}};

static void assert_bounds(const davar_config_t *config, double r4, double z)
{
    const double length = config->window.shortest;
    const double segment = config->moments.segment;
    const double spread = z * sqrt(24.0 * r4 / length) / 3.0;
    const double slides = sqrt(8.0 / 3.0 * r4 * segment / (length * (length - segment)));
    assert_near(3.0 / (1.0 + spread), config->moments.kurtosis_low, 2e-6);
    assert_near((spread < 0.9) ? (3.0 / (1.0 - spread)) : 30.0, config->moments.kurtosis_high,
                1e-4);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, config->moments.contribution_low);
    assert_near(z * (0.98 + (0.065 * ((z * z) - 4.0))) * slides, config->moments.contribution_high,
                1e-5);
}

static void test_bounds_of_a_stated_rate_match_their_formulas(void)
{
    static const davar_law_t *const laws[] = {&davar_law_or, &davar_law_kurtosis, &davar_law_and,
                                              NULL};
    for (size_t q = 0; q < 4U; q++) {
        for (size_t l = 0; l < 4U; l++) {
            davar_config_t config = davar_default_config;
            config.law = laws[l];
            config.moments.contribution_low = 0.5;
            config.window.shortest = 300U + (100U * (uint32_t)q);
            davar_bound_unstable_rate(&config, quantiles[q].rate, NULL);
            assert_bounds(&config, 1.0, ((l % 3U) == 0U) ? quantiles[q].each : quantiles[q].alone);
        }
    }
}

static void test_bounds_behind_a_filter_use_its_autocorrelation(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        davar_config_t config = davar_default_config;
        set_autocovariance(&filters[f], filters[f].cutoff);
        double r4 = 1.0;
        for (int k = 1; k < of_noise.count; k++) {
            r4 += 2.0 * pow(r_at(k) / r_at(0), 4.0);
        }
        bound_shape(&config, 0.01, &filters[f]);
        const double z = 2.807033768;
        const double slides = sqrt(8.0 / 3.0 * 100.0 / (400.0 * 300.0));
        const double found =
            config.moments.contribution_high / (z * (0.98 + (0.065 * ((z * z) - 4.0))) * slides);
        assert_near(r4, found * found, 5e-4); /* long averages: every n-th lag */
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_gains_match_the_autocovariance);
    RUN_TEST(test_covariances_match_the_autocovariance);
    RUN_TEST(test_a_sample_matches_the_autocovariance);
    RUN_TEST(test_offsets_are_derivatives_by_the_frequency);
    RUN_TEST(test_the_level_of_a_learned_filter_widens_the_interval);
    RUN_TEST(test_drifts_pass_the_filter_as_their_spectrum_does);
    RUN_TEST(test_the_power_gain_matches_the_autocovariance);
    RUN_TEST(test_sizes_beyond_the_filter_are_white);
    RUN_TEST(test_plans_of_the_longest_averages_are_plans);
    RUN_TEST(test_the_inverse_of_a_gain_saturates);
    RUN_TEST(test_whitening_matches_the_autocovariance);
    RUN_TEST(test_the_tolerance_is_that_of_the_cutoff);
    RUN_TEST(test_bounds_of_a_stated_rate_match_their_formulas);
    RUN_TEST(test_bounds_behind_a_filter_use_its_autocorrelation);
    return UNITY_END();
}
