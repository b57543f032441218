/* davar tests - the plan and the fit of filtered noise (5.16), and of samples whose filter is unknown
 * (5.17), from exact Allan variances. */
#include "filtered_fixture.h"
#include "fit/mixture.h"

/* ---- a declared filter ---- */

static void test_white_noise_has_the_value_before_the_filter(void)
{
    const double white[] = {0, 0.7, 0, 0, 0};
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        const double count = sqrt(0.7 * (double)plan.white.sample) / 5.0;
        for (int rounds = 0; rounds < 2; rounds++) {
            set_filtered(&filters[f], white, count * rounds);
            TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
            assert_near(arw_of(0.7), term(DAVAR_ANGLE_RANDOM_WALK)->value, 1e-4);
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low > 0.6 * arw_of(0.7));
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 1.04 * arw_of(0.7));
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high < 1.5 * arw_of(0.7));
        }
    }
}

/* A cutoff that is hardly known gives the short sizes negative weights. */
static const shape_t vague = {.cutoff = 0.05, .poles = 1U, .uncertainty = 0.3};

/* Noise of little more than a count, where rounding lowers the amplitude that the Allan variances
 * give. */
static void test_rounding_that_lowers_the_estimate_is_added_back(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    for (int step = 0; step < 20; step++) {
        const double over = 1.0 + 0.05 * step;
        plan_filter(&vague);
        TEST_ASSERT_TRUE(plan.white.rounding < -1.0F);
        const double count = 1.0 / ((double)plan.white.hidden * sqrt(1.5 * over));
        set_filtered(&vague, white, count);
        TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
        assert_near(60.0, term(DAVAR_ANGLE_RANDOM_WALK)->value, 2e-3);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low < 60.0);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
    }
}

/* Quantization that may be there takes a share of white noise, unless the weights of the filter
 * have the other sign. */
static void test_a_doubtful_term_lowers_the_limit_only_as_far_as_it_could(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        davar_fit_prepare(&plan, &result);
        const double sigma = (double)plan.white.sigma[0] / (double)(1U << DAVAR_FIT_SHARE_BITS) *
                             (double)plan.scale[0];
        const double none[] = {0, 1.0, 0, 0, 0};
        const double some[] = {sigma, 1.0, 0, 0, 0};
        set_filtered(&filters[f], none, 0.0);
        TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
        const double low = term(DAVAR_ANGLE_RANDOM_WALK)->low;
        set_filtered(&filters[f], some, 0.0);
        TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low < 1.01 * low);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low > 0.85 * low);
    }
}

/* In a short window, the doubt about rounding can exceed the noise that the lower limit leaves: next
 * to nothing then remains of it. */
static void test_the_doubt_about_rounding_can_leave_nothing(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U};
    const shape_t filter = {.cutoff = 0.1, .poles = 2U};
    unsigned nothing = 0U;
    unsigned some = 0U;
    for (uint32_t window = 18U; window < 400U; window += 20U) {
        set_taus(window, m, 4U);
        plan_shape(&plan, m, 4U, &filter);
        for (int step = 0; step < 200; step++) {
            const double count = 1.0 / ((double)plan.white.hidden * (1.0 + 0.01 * step));
            for (int t = 0; t < 4; t++) {
                const double rounding = count * count / 12.0;
                result.tau[t].adev = sqrt(((double)plan.gain[t] + rounding) / (double)m[t]);
            }
            result.unit_per_count = count;
            if (!davar_fit_white(&plan, 1.0, &result)) {
                TEST_ASSERT_EQUAL(DAVAR_NOISE_COARSE, result.noise);
                continue;
            }
            const double low = term(DAVAR_ANGLE_RANDOM_WALK)->low;
            assert_near(60.0, term(DAVAR_ANGLE_RANDOM_WALK)->value, 1e-3);
            TEST_ASSERT_TRUE((low >= 0.0) && (low < 60.0));
            nothing += ((low > 0.0) && (low < 0.1)) ? 1U : 0U;
            some += (low > 20.0) ? 1U : 0U;
        }
    }
    TEST_ASSERT_TRUE((nothing > 0U) && (some > 0U));
}

/* ---- drifts that pass the filter ---- */

static void assert_mix_found(const double mix[])
{
    static const double unit[] = {1.0 / 3.0, 3600.0, 3600.0 * 3600.0 * 2.2661800709135971,
                                  3.0 * 216000.0 * 216000.0, 2.0 * 12960000.0 * 12960000.0};
    const bool shows_white = term(DAVAR_ANGLE_RANDOM_WALK)->present;
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
    for (int k = 0; k < TERMS; k++) {
        const davar_coefficient_t *const found = &result.coefficient[k];
        const double truth = sqrt(mix[k] * unit[k]);
        TEST_ASSERT_EQUAL_INT((truth > 0.0) && ((k != WHITE) || shows_white), found->present);
        if (found->present) {
            TEST_ASSERT_TRUE((found->low < truth) && (truth < found->high));
            TEST_ASSERT_TRUE(!shows_white || (fabs(found->value - truth) < (0.01 * truth)));
        }
    }
}

static void test_drifts_behind_the_filter_are_found_with_their_size(void)
{
    static const double mixes[][DAVAR_COEFFICIENT_COUNT] = {
        {0, 1.0, 0.3, 0, 0}, {0, 1.0, 0, 0.02, 0}, {0, 1.0, 0, 0, 4e-4}};
    for (size_t f = 0; f < FILTERS; f++) {
        for (size_t i = 0; i < sizeof mixes / sizeof mixes[0]; i++) {
            plan_filter(&filters[f]);
            set_filtered(&filters[f], mixes[i], (double)i * 0.02);
            davar_fit(&plan, 1.0, &result);
            assert_mix_found(mixes[i]);
        }
    }
}

/* Nothing that passes at the short sizes bounds the angle random walk: davar_fit_white takes the
 * shortest size of which the filter passes 35 %. */
static void test_the_limit_beside_a_drift_is_of_a_size_that_passes(void)
{
    const double walk[] = {0, 1.0, 0, 0.1, 0};
    plan_filter(&filters[3]);
    set_filtered(&filters[3], walk, 0.0);
    TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE((plan.gain[2] < 0.35F) && (plan.gain[3] > 0.35F));
    TEST_ASSERT_EQUAL_UINT8(3U, plan.white.passed);
    davar_result_t again = result;
    plan.white.passed = 2U;
    (void)davar_fit_white(&plan, 1.0, &again);
    TEST_ASSERT_TRUE(again.coefficient[WHITE].high < term(DAVAR_ANGLE_RANDOM_WALK)->high);
    const double high = result.tau[3].adev * (double)plan.white.high[3];
    assert_near(60.0 * high * sqrt(8.0 / (double)plan.gain[3]), term(DAVAR_ANGLE_RANDOM_WALK)->high,
                1e-4);
}

/* (5.11): the limit of absent white noise, at the first size that passes the filter. */
static void test_the_limit_of_white_noise_that_a_mixture_lacks(void)
{
    const double flicker[] = {0, 1.0, 0.3, 0, 0};
    plan_filter(&filters[3]);
    set_filtered(&filters[3], flicker, 0.0);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
    davar_mixture_fit(&model, 1.0, 1U << DAVAR_BIAS_INSTABILITY);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_BIAS_INSTABILITY, model.terms);
    const double passed = pow((double)plan.flicker[3], 2.0) * model.a[DAVAR_BIAS_INSTABILITY];
    const double room = passed * 8.0 / (double)plan.gain[3];
    double low;
    double high;
    davar_chi_square_interval(1.42 * 2.0 * room * room / model.variance[WHITE], &low, &high);
    const double most = (model.tried[WHITE] * high) + (room * (high - 1.0));
    davar_fit(&plan, 1.0, &result);
    assert_near(60.0 * sqrt(most), term(DAVAR_ANGLE_RANDOM_WALK)->high, 1e-6);
}

/* If the filter passes 35 % of no size, the longest one bounds the angle random walk. */
static void test_the_limit_behind_a_filter_that_passes_no_size(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U};
    const shape_t filter = {.cutoff = 0.01, .poles = 2U};
    davar_plan_t truth;
    set_taus(WINDOW, m, 4U);
    plan_shape(&plan, m, 4U, &filter);
    memcpy(&truth, &plan, sizeof plan);
    TEST_ASSERT_TRUE(plan.gain[3] < 0.35F);
    for (int t = 0; t < 4; t++) {
        const double walk = 0.1 * (double)m[t] * pow((double)truth.walk[t], 2.0);
        result.tau[t].adev = sqrt(((double)truth.gain[t] / (double)m[t]) + walk);
    }
    davar_result_t again = result;
    TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &again));
    const double high = again.tau[3].adev * (double)plan.white.high[3];
    assert_near(60.0 * high * sqrt(8.0 / (double)plan.gain[3]), again.coefficient[WHITE].high,
                1e-4);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RANDOM_WALK)->present);
    TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
}

/* ---- a filter that the plan does not know ---- */

static void assert_withheld(void)
{
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    for (int k = 0; k < TERMS; k++) {
        TEST_ASSERT_FALSE(result.coefficient[k].present);
        TEST_ASSERT_TRUE(isnan(result.coefficient[k].low));
        TEST_ASSERT_TRUE((k == WHITE) || isinf(result.coefficient[k].high));
    }
    for (int t = 0; t < SIZES; t++) {
        TEST_ASSERT_TRUE(result.tau[t].edf >= 1.0);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[t].low);
        TEST_ASSERT_TRUE(isinf(result.tau[t].high));
    }
}

static void test_short_sizes_that_read_low_withhold_everything(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    const double drift[] = {0, 1.0, 0, 0.02, 0};
    for (size_t f = 1; f < FILTERS; f++) {
        if (f != 6) { /* two poles at 0.45 cannot be seen in 600 samples */
            plan_filter(NULL);
            set_filtered(&filters[f], white, 0.0);
            TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
            assert_withheld();
            davar_fit(&plan, 1.0, &result);
            assert_withheld();
            set_filtered(&filters[f], drift, 0.0);
            davar_fit(&plan, 1.0, &result);
            assert_withheld();
        }
    }
}

/* (5.17): from the first size that its longer neighbour does not exceed. */
static void test_the_limit_behind_a_filter_that_is_not_declared(void)
{
    for (int top = 1; top < SIZES; top++) {
        plan_filter(NULL);
        double y[SIZES];
        for (int t = 0; t < SIZES; t++) {
            const double size = (double)result.tau[t].m;
            y[t] = (t <= top) ? (1.0 - pow(0.5, t + 1.0)) : (0.9 - pow(0.5, top + 1.0));
            result.tau[t].adev = sqrt(y[t] / size);
        }
        result.unit_per_count = 0.0;
        TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
        TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
        const double limit = y[top] * pow((double)plan.white.high[top], 2.0);
        const double most = limit + 3.0 * (y[top] - y[top - 1]);
        assert_near(60.0 * sqrt(most), term(DAVAR_ANGLE_RANDOM_WALK)->high, 1e-5);
    }
}

/* More than the filter passes at the shortest size can make the amplitude of white noise negative,
 * where weights are. That is no rounding: a mixture finds quantization, which passes no filter. */
static void test_a_term_that_lowers_the_estimate_is_not_taken_for_rounding(void)
{
    for (int step = 0; step < 25; step++) {
        const double q = 0.005 * pow(1.5, step);
        for (int counts = 0; counts < 2; counts++) {
            const double mix[] = {q, 1.0, 0, 0, 0};
            plan_filter(&filters[4]);
            set_filtered(&filters[4], mix, 0.06 * counts);
            TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
            TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
            davar_fit(&plan, 1.0, &result);
            assert_withheld();
        }
    }
}

/* A drift or quantization of half a count keeps a mixture from being coarse. Only its white noise
 * is then withdrawn. */
static void test_other_terms_can_scatter_a_sample_enough(void)
{
    static const struct {
        size_t filter;
        double mix[DAVAR_COEFFICIENT_COUNT]; /* in units of the white noise that rounding hides */
        davar_noise_t noise;
    } cases[] = {
        {0, {2.0, 0.5, 0, 0, 0}, DAVAR_NOISE_MIXED},
        {0, {0.3, 0.5, 0, 0, 0}, DAVAR_NOISE_COARSE},
        {0, {0, 0.5, 0, 0.505, 0}, DAVAR_NOISE_MIXED},
        {0, {0, 0.5, 0, 0.495, 0}, DAVAR_NOISE_COARSE},
        {1, {0, 0.5, 0, 0.2, 0}, DAVAR_NOISE_MIXED},
        {1, {0, 0.5, 0, 0.06, 0}, DAVAR_NOISE_COARSE},
        {8, {0, 0.5, 0.2, 0, 0}, DAVAR_NOISE_MIXED},
        {8, {0, 0.5, 0.05, 0, 0}, DAVAR_NOISE_COARSE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        plan_filter(&filters[cases[i].filter]);
        set_filtered(&filters[cases[i].filter], cases[i].mix, 1.0 / (double)plan.white.hidden);
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(cases[i].noise, result.noise);
        TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 60.0 * (1.0 - 1e-6));
    }
}

/* Up to twice the scatter that rounding, and the noise that it hides, give to the shortest size. */
static void test_more_scatter_than_hidden_noise_gives_is_no_rounding(void)
{
    for (int step = 0; step < 29; step++) {
        const double over = 1.15 + 0.1 * step;
        plan_filter(&vague);
        const double hidden =
            ldexp(1.0 / 12.0, 30) / (double)plan.white.coarse * (double)plan.gain[0];
        const double white[] = {over * (hidden + (1.0 / 12.0)) - (1.0 / 12.0), 1e-3, 0, 0, 0};
        set_filtered(&vague, white, 1.0);
        const davar_noise_t expected = (over < 2.0) ? DAVAR_NOISE_COARSE : DAVAR_NOISE_MIXED;
        TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
        TEST_ASSERT_EQUAL(expected, result.noise);
    }
}

/* Where the errors of a narrow filter repeat, up to twice the noise that is hidden. */
static void test_noise_of_less_than_half_a_count_is_coarse(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        bool was_white = false;
        for (int step = 0; step < 40; step++) {
            const double over = 0.25 + 0.05 * step;
            const double white[] = {0, 1.0, 0, 0, 0};
            plan_filter(&filters[f]);
            const double half = sqrt(ldexp(1.0 / 12.0, 30) / (double)plan.white.coarse);
            const double hidden = (double)plan.white.hidden;
            set_filtered(&filters[f], white, 1.0 / (hidden * over));
            davar_fit(&plan, 1.0, &result);
            const bool is_white = (result.noise == DAVAR_NOISE_WHITE);
            TEST_ASSERT_TRUE(is_white || ((result.noise == DAVAR_NOISE_COARSE) && !was_white));
            TEST_ASSERT_TRUE(!is_white || (over * hidden > half));
            TEST_ASSERT_TRUE(is_white || (over < 1.0) ||
                             ((over < 2.0) && (plan.white.step < 0.2F)));
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 59.999);
            was_white = is_white;
        }
    }
}

/* (5.9) with (5.16): each size counts by the scatter of its estimate and the doubt of its gain. */
static void test_the_misfit_of_a_mixture_counts_the_doubt_of_the_cutoff(void)
{
    for (int step = 0; step < 5; step++) {
        const double unit = 1e-4 * pow(100.0, step);
        const double mix[] = {0, unit * unit, 0, 0.001 * unit * unit, 0};
        plan_filter(&filters[4]);
        set_filtered(&filters[4], mix, 0.0);
        for (int t = 0; t < SIZES; t++) {
            result.tau[t].adev *= (t % 2 == 0) ? 1.25 : 0.75;
        }
        davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
        davar_mixture_fit(&model, unit * unit, 1U << DAVAR_RATE_RANDOM_WALK);
        double misfit = 0.0;
        int terms = 0;
        for (int t = 0; t < SIZES; t++) {
            const double m = (double)plan.m[t];
            const double white = model.a[WHITE] * (double)plan.gain[t] / m;
            const double shape[] = {1.0 / (m * m), (double)plan.gain[t] / m,
                                    pow((double)plan.flicker[t], 2.0),
                                    m * pow((double)plan.walk[t], 2.0), m * m};
            const double avar = dot_terms(model.a, shape);
            const double off = white * (double)plan.offset[t] / avar;
            const double ratio = result.tau[t].adev * result.tau[t].adev / avar;
            const double loss = 1.5 * (ratio - 1.0) * (ratio - 1.0) / (1.0 + (2.0 * ratio));
            misfit += loss / ((1.0 / davar_mixture_edf(&model, t)) + (0.5 * off * off));
        }
        for (int k = 0; k < TERMS; k++) {
            terms += ((model.terms >> (unsigned)k) & 1U) != 0U ? 1 : 0;
        }
        TEST_ASSERT_TRUE((model.grow > 1.0) && (model.a[WHITE] > 0.5 * unit * unit));
        assert_near(misfit / (SIZES - terms), model.grow, 1e-6);
    }
}

/* A cutoff that is off by less than its uncertainty is no misfit of a mixture. Without uncertainty
 * it is one. Both in any unit. */
static void test_an_uncertain_cutoff_explains_its_misfit_in_any_unit(void)
{
    const double drift[] = {0, 1.0, 0, 0.02, 0};
    const shape_t real = {.cutoff = 0.27, .poles = 1U};
    for (int step = 0; step < 9; step++) {
        const double unit = 1e-4 * pow(10.0, step);
        for (int known = 0; known < 2; known++) {
            const shape_t declared = {
                .cutoff = 0.25, .poles = 1U, .uncertainty = (known != 0) ? 0.0 : 0.1};
            plan_filter(&declared);
            set_filtered(&real, drift, 0.0);
            result.window_samples = 60000U;
            for (int t = 0; t < SIZES; t++) {
                result.tau[t].differences = 60001U - (2U * result.tau[t].m);
                result.tau[t].adev *= unit;
            }
            davar_fit(&plan, 1.0, &result);
            if (known != 0) {
                assert_withheld();
            } else {
                TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
                assert_near(60.0 * unit, term(DAVAR_ANGLE_RANDOM_WALK)->value, 0.05);
            }
        }
    }
}

/* A ramp hides white noise. With a plan that knows no filter, it may hide a filter too. */
static void test_a_mixture_without_white_noise_may_hide_a_filter(void)
{
    const double drift[] = {0, 1e-3, 0, 1.0, 0};
    plan_filter(NULL);
    set_filtered(&filters[0], drift, 0.0);
    for (int t = 0; t < SIZES; t++) {
        result.tau[t].adev = sqrt(avar_at(drift, result.tau[t].m));
    }
    davar_fit(&plan, 1.0, &result);
    assert_withheld();
    plan.white.declared = true;
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
}

/* With too few sizes to see a lack: flicker that leaves no white noise, and a misfit. */
static void test_a_mixture_of_an_unknown_filter_must_fit_and_show_white_noise(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U};
    const double flicker[] = {0, 1.0, 0.63, 0, 0};
    const double white[] = {0, 1.0, 0, 0, 0};
    for (int way = 0; way < 2; way++) {
        set_octaves((way == 0) ? 90U : 100000U, (way == 0) ? 4U : 13U);
        set_model((way == 0) ? flicker : white);
        if (way == 0) {
            davar_plan_init(&plan, m, 4U);
        } else {
            plan.white.declared = false;
        }
        for (int t = 3; (way != 0) && (t < 13); t += 2) {
            result.tau[t].adev *= 0.9;
        }
        davar_result_t known = result;
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
        plan.white.declared = true;
        davar_fit(&plan, 1.0, &known);
        TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, known.noise);
        TEST_ASSERT_EQUAL_INT(way != 0, known.coefficient[WHITE].present);
    }
}

/* (5.17): as much as passes the test may be missing from N^2: three standard errors of the lack,
 * and the lack that the window shows. */
static void test_the_upper_limit_includes_what_the_test_cannot_see(void)
{
    for (int step = 0; step < 5; step++) {
        const double lack = 0.5 * step;
        plan_filter(NULL);
        davar_fit_prepare(&plan, &result);
        const double sigma = (double)plan.white.sigma[0] / (double)(1U << DAVAR_FIT_SHARE_BITS) *
                             (double)plan.scale[0];
        const double centre = (double)plan.white.centre[0] / (double)plan.scale[0];
        const double mix[] = {-lack * sigma, 1.0, 0, 0, 0};
        set_model(mix);
        davar_result_t known = result;
        davar_fit(&plan, 1.0, &result);
        plan.white.declared = true;
        plan.white.window = 0U;
        davar_fit(&plan, 1.0, &known);
        TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
        TEST_ASSERT_EQUAL_DOUBLE(known.coefficient[WHITE].value, result.coefficient[WHITE].value);
        TEST_ASSERT_EQUAL_DOUBLE(known.coefficient[WHITE].low, result.coefficient[WHITE].low);
        const double share = centre * sigma / (1.0 - (lack * centre * sigma));
        const double more = 1.0 + (0.5 * ((3.0 * centre * sigma) + (lack * share)));
        assert_near(more * known.coefficient[WHITE].high, result.coefficient[WHITE].high, 1e-3);
    }
}

static void test_the_upper_limit_of_a_mixture_includes_it_too(void)
{
    static const uint32_t m[] = {2U, 4U, 8U, 16U, 32U, 64U};
    const double drift[] = {-0.002, 1.0, 0, 0.001, 0};
    set_taus(WINDOW, m, 6U);
    davar_plan_init(&plan, m, 6U);
    set_model(drift);
    davar_result_t known = result;
    davar_fit(&plan, 1.0, &result);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
    davar_mixture_fit(&model, 1.0, 1U << DAVAR_RATE_RANDOM_WALK);
    plan.white.declared = true;
    davar_fit(&plan, 1.0, &known);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_EQUAL_DOUBLE(known.coefficient[WHITE].value, result.coefficient[WHITE].value);
    TEST_ASSERT_EQUAL_DOUBLE(known.coefficient[WHITE].low, result.coefficient[WHITE].low);
    TEST_ASSERT_TRUE(model.tried[DAVAR_QUANTIZATION] < 0.0);
    const double unseen = (3.0 * sqrt(model.variance[0])) - model.tried[0];
    assert_near(known.coefficient[WHITE].high * sqrt(1.0 + (unseen / 2.0 / model.a[WHITE])),
                result.coefficient[WHITE].high, 1e-6);
}

/* ---- the weights (5.4) ---- */

static double functional(int term, int t)
{
    const double one =
        (term == WHITE) ? (double)(UINT32_C(1) << plan.white.white_bits) : (double)plan.scale[term];
    return (double)plan.white.functional[term][t] / DAVAR_FIT_FUNCTIONAL_ONE * one;
}

static double shape(int term, int t)
{
    const double m = (double)plan.m[t];
    const double u = m / (double)plan.m[SIZES - 1];
    const double passed[] = {(double)plan.m[0] / m, (double)plan.gain[t],
                             u * pow((double)plan.flicker[t], 2.0),
                             u * u * pow((double)plan.walk[t], 2.0), u * u * u};
    return passed[term] / (double)plan.gain[t];
}

/* Covariance of m avar / gain for N = 1, in a window of nine longest sizes, with the offset of an
 * uncertain cutoff and 1e-4 of the diagonal. */
static double plan_covariance(int t, int u)
{
    const double differences = (9.0 * (double)plan.m[SIZES - 1]) + 1.0 - (1.5 * (double)plan.m[t]);
    const double offset = (double)plan.offset[t] * (double)plan.offset[u];
    const double whole = ((double)plan.covariance[plan_pair(t, u)] / differences) + offset;
    return whole * ((t == u) ? 1.0001 : 1.0);
}

static double dot(const double a[], const double b[])
{
    double sum = 0.0;
    for (int t = 0; t < SIZES; t++) {
        sum += a[t] * b[t];
    }
    return sum;
}

/* Generalised least squares: among the functionals with the same gain of every shape, the variance
 * is least, so that the covariance times the functional is a sum of the shapes. */
static void assert_least_squares(int term)
{
    double f[SIZES];
    double x[SIZES];
    double one[SIZES];
    double image[SIZES];
    for (int t = 0; t < SIZES; t++) {
        f[t] = functional(term, t);
        x[t] = shape(term, t);
        one[t] = 1.0;
    }
    for (int t = 0; t < SIZES; t++) {
        image[t] = 0.0;
        for (int u = 0; u < SIZES; u++) {
            image[t] += f[u] * plan_covariance((t < u) ? t : u, (t < u) ? u : t);
        }
    }
    const double size = sqrt(dot(f, image)); /* standard error */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, dot(f, x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * size, (term == WHITE) ? 1.0 : 0.0, dot(f, one));
    const int end = SIZES - 1;
    const double slope = (term == WHITE) ? 0.0 : ((image[end] - image[0]) / (x[end] - x[0]));
    for (int t = 0; t < SIZES; t++) {
        const double expected = image[0] + (slope * (x[t] - x[0]));
        const double scatter = size * sqrt(plan_covariance(t, t));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * scatter, expected, image[t]);
    }
}

static void test_the_weights_have_the_least_variance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        for (int k = 0; k < TERMS; k++) {
            assert_least_squares(k);
        }
    }
}

/* The standard error of a term in the window: covariances over the effective differences of the
 * shorter size, less the rounding that they include, and the cutoff. */
static double expected_sigma(int term, double *by_cutoff)
{
    double variance = 0.0;
    double rounding = 0.0;
    double moved = 0.0;
    for (int u = 0; u < SIZES; u++) {
        for (int t = 0; t < SIZES; t++) {
            const int first = (t < u) ? t : u;
            const double effective = (double)WINDOW + 1.0 - (1.5 * (double)plan.m[first]);
            const int pair = plan_pair(first, (t < u) ? u : t);
            variance += functional(term, t) * functional(term, u) * (double)plan.covariance[pair] /
                        effective;
        }
        rounding += functional(WHITE, u) / (double)plan.gain[u];
        moved += functional(term, u) * (double)plan.offset[u];
    }
    *by_cutoff = ((term == WHITE) ? 1.25 : 1.0) * moved * moved;
    return sqrt((variance * pow(1.0 + (0.25 * (double)plan.floor * rounding), -2.0)) + *by_cutoff);
}

static void test_standard_errors_include_the_cutoff(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        davar_fit_prepare(&plan, &result);
        for (int k = 0; k < TERMS; k++) {
            double by_cutoff;
            const double scale = (k == WHITE) ? 1.0 : (double)plan.scale[k];
            const double expected = expected_sigma(k, &by_cutoff) / scale;
            const double found = (double)plan.white.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS);
            TEST_ASSERT_DOUBLE_WITHIN((1e-3 * expected) + 2e-6, expected, found);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * by_cutoff, by_cutoff,
                                      (double)plan.offset_variance[k] * scale * scale);
        }
    }
}

/* What a size contributes: the factor to N^2, the degrees of freedom, the doubt by the cutoff and
 * the rounding that the estimate of N^2 does not take off. */
static void test_sizes_have_their_own_factors(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        double moved = 0.0;
        double rounding = 0.0;
        plan_filter(&filters[f]);
        for (int t = 0; t < SIZES; t++) {
            moved += functional(WHITE, t) * (double)plan.offset[t];
            rounding += functional(WHITE, t) / (double)plan.gain[t];
        }
        assert_near(rounding, (double)plan.white.rounding, 1e-5);
        for (int t = 0; t < SIZES; t++) {
            const double gain = (double)plan.gain[t];
            const double floor = (double)plan.floor / gain;
            const double freedom =
                2.0 * pow(1.0 + floor, 2.0) / (double)plan.covariance[plan_pair(t, t)];
            assert_near((double)plan.m[t] / gain, (double)plan.white.to_white[t], 1e-6);
            assert_near(freedom, (double)plan.freedom[t], 1e-5);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5 * pow((double)plan.offset[t] - moved, 2.0),
                                      (double)plan.doubtful[t]);
            TEST_ASSERT_DOUBLE_WITHIN((0.51 / 512.0) + (1e-6 / gain), 1.0 / gain,
                                      (double)plan.white.inverse_gain[t] / 512.0);
        }
    }
}

/* At least 2^-32, also where a filter makes it negative, and at most 2^20, also where the sizes
 * hardly differ. */
static void test_centres_fit_a_shift(void)
{
    static const uint32_t alike[] = {4000000U, 4000001U};
    plan_filter(&vague);
    TEST_ASSERT_EQUAL_HEX32(davar_bits_of_float(ldexpf(1.0F, -32)),
                            davar_bits_of_float(plan.white.centre[DAVAR_QUANTIZATION]));
    TEST_ASSERT_TRUE(plan.white.centre[DAVAR_BIAS_INSTABILITY] > 0.1F);
    davar_plan_init(&plan, alike, 2U);
    TEST_ASSERT_EQUAL_HEX32(davar_bits_of_float(ldexpf(1.0F, 20)),
                            davar_bits_of_float(plan.white.centre[DAVAR_QUANTIZATION]));
}

/* ---- the plan ---- */

/* Here the covariance is none, so the second size gets no weight, and no other term is resolved. */
static void test_a_covariance_that_is_none_gives_finite_weights(void)
{
    plan_filter(&filters[0]);
    plan.covariance[plan_pair(0, 1)] = 2.0F * plan.covariance[plan_pair(1, 1)];
    davar_plan_solve(&plan, 2U);
    TEST_ASSERT_TRUE(isfinite((double)plan.white.rounding));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, functional(WHITE, 0));
    TEST_ASSERT_EQUAL_INT32(0, plan.white.functional[WHITE][1]);
    for (int k = 0; k < TERMS; k++) {
        TEST_ASSERT_TRUE(isfinite((double)plan.offset_variance[k]));
        for (int t = 0; (k != WHITE) && (t < 2); t++) {
            TEST_ASSERT_EQUAL_INT32(0, plan.white.functional[k][t]);
            TEST_ASSERT_EQUAL_INT32(0, plan.variance[k][t]);
        }
    }
}

/* A short window fits its sizes as a plan for these alone does. */
static void test_a_short_window_uses_its_sizes_alone(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    for (size_t f = 0; f < FILTERS; f++) {
        davar_plan_t short_plan;
        uint32_t m[SIZES];
        plan_filter(&filters[f]);
        set_filtered(&filters[f], white, 0.0);
        for (int t = 0; t < SIZES; t++) {
            m[t] = result.tau[t].m;
            result.tau[t].differences = (t < 4) ? (101U - (2U * m[t])) : ((f % 2U == 0U) ? 0U : 9U);
        }
        result.tau_count = (f % 2U == 0U) ? SIZES : 4U; /* the others are left from before */
        result.window_samples = 100U;
        plan_shape(&short_plan, m, 4U, &filters[f]);
        davar_result_t again = result;
        davar_fit(&plan, 1.0, &result);
        davar_fit(&short_plan, 1.0, &again);
        TEST_ASSERT_TRUE(result.coefficient[WHITE].present);
        assert_near(again.coefficient[WHITE].value, result.coefficient[WHITE].value, 1e-4);
        assert_near(again.coefficient[WHITE].high, result.coefficient[WHITE].high, 1e-3);
        TEST_ASSERT_TRUE((f % 2U != 0U) || isnan(result.tau[4].edf));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_has_the_value_before_the_filter);
    RUN_TEST(test_rounding_that_lowers_the_estimate_is_added_back);
    RUN_TEST(test_a_doubtful_term_lowers_the_limit_only_as_far_as_it_could);
    RUN_TEST(test_the_doubt_about_rounding_can_leave_nothing);
    RUN_TEST(test_drifts_behind_the_filter_are_found_with_their_size);
    RUN_TEST(test_the_limit_beside_a_drift_is_of_a_size_that_passes);
    RUN_TEST(test_the_limit_of_white_noise_that_a_mixture_lacks);
    RUN_TEST(test_the_limit_behind_a_filter_that_passes_no_size);
    RUN_TEST(test_short_sizes_that_read_low_withhold_everything);
    RUN_TEST(test_the_limit_behind_a_filter_that_is_not_declared);
    RUN_TEST(test_a_term_that_lowers_the_estimate_is_not_taken_for_rounding);
    RUN_TEST(test_more_scatter_than_hidden_noise_gives_is_no_rounding);
    RUN_TEST(test_an_uncertain_cutoff_explains_its_misfit_in_any_unit);
    RUN_TEST(test_the_misfit_of_a_mixture_counts_the_doubt_of_the_cutoff);
    RUN_TEST(test_noise_of_less_than_half_a_count_is_coarse);
    RUN_TEST(test_other_terms_can_scatter_a_sample_enough);
    RUN_TEST(test_a_mixture_without_white_noise_may_hide_a_filter);
    RUN_TEST(test_a_mixture_of_an_unknown_filter_must_fit_and_show_white_noise);
    RUN_TEST(test_the_upper_limit_includes_what_the_test_cannot_see);
    RUN_TEST(test_the_upper_limit_of_a_mixture_includes_it_too);
    RUN_TEST(test_the_weights_have_the_least_variance);
    RUN_TEST(test_standard_errors_include_the_cutoff);
    RUN_TEST(test_sizes_have_their_own_factors);
    RUN_TEST(test_centres_fit_a_shift);
    RUN_TEST(test_a_covariance_that_is_none_gives_finite_weights);
    RUN_TEST(test_a_short_window_uses_its_sizes_alone);
    return UNITY_END();
}
