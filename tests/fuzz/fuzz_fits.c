/* davar tests - the fit and its helpers on any filter, cluster sizes, deviations and rate within
 * their ranges: every number is in its range or absent, and intervals contain their value. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/monitor.h"
#include "digest.h"
#include "fuzzing.h"

#include <math.h>
#include <string.h>

#define LONGEST (UINT32_C(1) << 31U) /* cluster size; window and mirrored samples together */

static uint32_t taus[DAVAR_TAUS_MAX];
static uint8_t sizes;
static davar_filter_t filter;
static davar_plan_t plan;
static davar_result_t result;

/* 1 to below 2, times 2^low to 2^high. */
static double number(bytes_t *bytes, int low, int high)
{
    const double mantissa = 1.0 + (ldexp((double)word(bytes, 4U), -32));
    return ldexp(mantissa, low + (int)((uint32_t)word(bytes, 4U) % (uint32_t)(high - low)));
}

/* --- what the caller chooses --- */

/* A number from -2 to 2. */
static double coefficient(bytes_t *bytes)
{
    return ldexp((double)word(bytes, 4U), -30) - 2.0;
}

/* Any part in series. */
static void append_part(bytes_t *bytes)
{
    const double cutoff = ldexp((double)word(bytes, 4U), -31); /* to 2 */
    const double first = coefficient(bytes);
    const double second = coefficient(bytes);
    const double pole = coefficient(bytes);
    const double b[2] = {first, second};
    const double a[2] = {1.0, 0.5 * pole};
    const uint32_t length = (uint32_t)word(bytes, 2U) % 200U;
    const uint32_t order = byte(bytes) % 10U;
    switch (byte(bytes) % 8U) {
    case 0U:
        davar_filter_low_pass(&filter, cutoff, order % 4U, 0.003 * (double)length);
        break;
    case 1U:
        davar_filter_biquad(&filter, 0.3 * cutoff);
        break;
    case 2U:
        davar_filter_pt1(&filter, cutoff);
        break;
    case 3U:
        davar_filter_notch(&filter, 0.3 * cutoff, 0.1 * (double)length);
        break;
    case 4U:
        davar_filter_average(&filter, order, length);
        break;
    case 5U:
        davar_filter_cic(&filter, order, length % 33U);
        break;
    case 6U:
        davar_filter_sum(&filter, length % 33U);
        break;
    default:
        davar_filter_ba(&filter, b, 2U, a, 2U);
        break;
    }
}

/* Up to four parts. Of a series that is not valid, no part. */
static void choose_filter(bytes_t *bytes)
{
    const uint32_t parts = between(bytes, 0U, 4U);
    filter = (davar_filter_t){.b = {0.0}};
    for (uint32_t i = 0U; i < parts; i++) {
        append_part(bytes);
    }
    filter.level = ldexp((double)byte(bytes), -9);
    if (!davar_filter_is_valid(&filter)) {
        filter = (davar_filter_t){.b = {0.0}};
    }
}

/* Octaves, a geometric row, or any. */
static void choose_taus(bytes_t *bytes)
{
    const uint32_t shift = between(bytes, 8U, 28U);
    const uint32_t window = 2U + ((uint32_t)word(bytes, 4U) >> shift);
    const uint8_t most = (uint8_t)between(bytes, 1U, DAVAR_TAUS_MAX);
    sizes = 0U;
    const uint8_t row = byte(bytes) % 4U;
    if (row == 0U) {
        sizes = davar_taus_octave(window, taus, most);
    } else if (row == 1U) {
        sizes = davar_taus_geometric(window, (uint8_t)between(bytes, 1U, 40U), taus, most);
    } else {
        for (uint32_t m = between(bytes, 1U, 64U); (sizes < most) && (m < LONGEST); sizes++) {
            taus[sizes] = m;
            m += 1U + ((uint32_t)word(bytes, 4U) % m);
        }
    }
    for (uint8_t t = 0U; t < sizes; t++) {
        REQUIRE((taus[t] >= 1U) && ((t == 0U) || (taus[t] > taus[t - 1U])));
        add(taus[t]);
    }
    REQUIRE(sizes <= most);
}

static void choose_plan(bytes_t *bytes)
{
    const uint8_t which = byte(bytes) % 3U;
    if (which == 0U) {
        davar_plan_init(&plan, taus, sizes);
    } else if (which == 1U) {
        davar_plan_init_white(&plan, taus, sizes);
    } else {
        davar_plan_init_filtered(&plan, taus, sizes, &filter);
    }
}

/* m^(quarters / 4), the same on every machine. */
static double power_of_root(uint32_t m, int quarters)
{
    const double root = sqrt(sqrt((double)m));
    double power = 1.0;
    for (int i = 0; i < abs(quarters); i++) {
        power = (quarters > 0) ? (power * root) : (power / root);
    }
    return power;
}

/* White noise, a drift, or anything, within a part of its scatter; counts from fine to coarse. */
static void choose_result(bytes_t *bytes)
{
    const double level = number(bytes, -160, 160);
    const int quarters = (int)between(bytes, 0U, 8U) - 4; /* of the slope */
    const uint8_t kind = byte(bytes);
    result = (davar_result_t){.tau_count = sizes, .unit_per_count = 0.0};
    const uint64_t samples = (uint64_t)taus[sizes - 1U] * between(bytes, 1U, 40U);
    const uint32_t window = (uint32_t)((samples < LONGEST) ? samples : LONGEST);
    const uint32_t more = byte(bytes) + ((window < 2U) ? 2U : 0U);
    result.window_samples = window + ((more < (LONGEST - window)) ? more : (LONGEST - window));
    const uint32_t mirrored = (result.window_samples / 256U) * (kind % 64U);
    const uint32_t room = LONGEST - result.window_samples;
    result.mirrored_samples = (mirrored < room) ? mirrored : room;
    const uint32_t cut_age = ((kind % 4U) == 1U) ? (uint32_t)word(bytes, 4U) : 0U;
    result.chosen = ((kind % 8U) == 3U) || ((cut_age - (cut_age / 2U)) > result.window_samples);
    result.kurtosis = (kind < 64U) ? 1.0 + number(bytes, -8, 8) : (double)NAN;
    result.dispersion = (kind < 160U) ? 1.0 + number(bytes, -8, 8) : (double)NAN;
    result.unit_per_count = ((kind % 2U) == 0U) ? level * number(bytes, -12, 4) : 0.0;
    for (uint8_t t = 0U; t < sizes; t++) {
        davar_adev_t *const tau = &result.tau[t];
        const uint32_t m = taus[t];
        const uint8_t what = byte(bytes);
        const uint32_t all =
            (result.window_samples >= (2U * m)) ? result.window_samples + 1U - (2U * m) : 0U;
        tau->m = m;
        tau->differences = (what < 240U) ? all : (all / 256U) * (what - 239U);
        if ((t > 0U) && (tau->differences > result.tau[t - 1U].differences)) {
            tau->differences = result.tau[t - 1U].differences; /* longer ones have no more */
        }
        tau->adev = level * power_of_root(m, quarters) * (1.0 + ((double)what / 1024.0));
        tau->adev =
            (what == 255U) ? level * number(bytes, -32, 32) : ((what == 254U) ? 0.0 : tau->adev);
        tau->adev = (tau->differences > 0U) ? tau->adev : (double)NAN;
        tau->low = tau->high = tau->edf = (double)NAN;
    }
}

/* --- what it must get --- */

static void check_result(bool is_white)
{
    add((uint64_t)result.noise);
    REQUIRE(is_white == (result.noise == DAVAR_NOISE_WHITE));
    for (uint8_t t = 0U; t < sizes; t++) {
        const davar_adev_t *const tau = &result.tau[t];
        check_deviation(tau);
        if (tau->differences > 0U) {
            add_double(tau->edf);
            add_double(tau->low);
            add_double(tau->high);
        }
    }
    for (unsigned kind = 0U; kind < (unsigned)DAVAR_COEFFICIENT_COUNT; kind++) {
        const davar_coefficient_t *const coefficient = &result.coefficient[kind];
        check_coefficient(coefficient);
        add(coefficient->present ? 1U : 0U);
        add_double(coefficient->value);
        add_double(coefficient->low);
        add_double(coefficient->high);
    }
    REQUIRE(!is_white || result.coefficient[DAVAR_ANGLE_RANDOM_WALK].present);
}

/* The flat part gives the angle random walk only where it is absent, and keeps the kind of noise. */
static void fit_flat(double rate_hz)
{
    const davar_result_t before = result;
    const bool given = before.coefficient[DAVAR_ANGLE_RANDOM_WALK].present;
    const bool found = davar_fit_flat(&plan, rate_hz, &result);
    REQUIRE(found == result.coefficient[DAVAR_ANGLE_RANDOM_WALK].present);
    REQUIRE((result.noise == before.noise) && (found || !given));
    REQUIRE((found && !given) == (result.flat_to > 0U));
    REQUIRE(result.flat_from <= result.flat_to);
    add(result.flat_from + ((uint64_t)result.flat_to << 32U));
    check_result(result.noise == DAVAR_NOISE_WHITE);
}

/* Where the plan fits a whole window, its constant part gives the same. */
static void fit_walk(const davar_result_t *given)
{
    const davar_result_t usual = result;
    const davar_coefficient_t *const one = &usual.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const davar_coefficient_t *const other = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    if ((usual.noise != DAVAR_NOISE_UNKNOWN) && (plan.white.window > 0U)) {
        result = *given;
        REQUIRE(davar_fit_walk(&plan.white, &result) == one->present);
        REQUIRE(result.noise == usual.noise);
        REQUIRE(is_same(one->value, other->value));
        REQUIRE(is_same(one->low, other->low));
        REQUIRE(is_same(one->high, other->high));
    }
}

/* Both fits agree where white noise explains the window. */
static void fit(double rate_hz)
{
    const davar_result_t given = result;
    const bool is_white = davar_fit_white(&plan, rate_hz, &result);
    check_result(is_white);
    fit_flat(rate_hz);
    const davar_coefficient_t arw = result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    result = given;
    davar_fit(&plan, rate_hz, &result);
    check_result(result.noise == DAVAR_NOISE_WHITE);
    fit_flat(rate_hz);
    REQUIRE(!is_white || (result.noise == DAVAR_NOISE_WHITE));
    const double value = result.coefficient[DAVAR_ANGLE_RANDOM_WALK].value;
    REQUIRE(!is_white || ((arw.value <= value) && (arw.value >= value)));
    result = given;
    check_result(davar_fit_white_ready(&plan, rate_hz, &result));
    fit_walk(&given);
}

static void check_degrees(bytes_t *bytes)
{
    for (uint8_t t = 0U; t < sizes; t++) {
        if (result.tau[t].differences > 0U) {
            const double edf = davar_edf_least(&result, t);
            double low = 0.0;
            double high = 0.0;
            davar_chi_square_interval(edf, &low, &high);
            REQUIRE((edf >= 1.0) && (low > 0.0) && (low < 1.0) && (high > 1.0));
            const davar_model_tau_t model = {taus[t], number(bytes, -160, 160), 0.0};
            const double deviation = davar_deviation(result.tau[t].adev, edf, &model);
            REQUIRE(!isnan(deviation));
            add_double(deviation);
            for (unsigned kind = 0U; kind < (unsigned)DAVAR_COEFFICIENT_COUNT; kind++) {
                const double pure =
                    davar_edf((davar_coefficient_kind_t)kind, taus[t], result.window_samples);
                REQUIRE((pure >= 1.0) && isfinite(pure));
                add_double(pure);
            }
            add_double(edf);
        }
    }
}

static void check_filter(bytes_t *bytes)
{
    const double power = davar_filter_power(&filter, ldexp((double)word(bytes, 4U), -33));
    static const davar_law_t *const laws[] = {&davar_law_kurtosis, &davar_law_or, &davar_law_and};
    davar_config_t config = davar_default_config;
    REQUIRE((power >= 0.0) && isfinite(power));
    config.glr.block = between(bytes, 5U, 64U);
    config.law = laws[byte(bytes) % 3U];
    config.window.shortest = between(bytes, 8U, 200U);
    config.moments.segment = between(bytes, 2U, config.window.shortest - 1U);
    davar_whiten(&config, &filter);
    davar_bound_unstable_rate(&config, 1e-4 + (0.0999 * ldexp((double)word(bytes, 4U), -32)),
                              &filter);
    REQUIRE(isfinite(config.glr.whiten_level) && (config.glr.whiten_level > 0.0));
    REQUIRE(config.glr.whiten_tolerance >= 0.0);
    REQUIRE(config.moments.kurtosis_low <= config.moments.kurtosis_high);
    REQUIRE(config.moments.contribution_low <= config.moments.contribution_high);
    add_double(power);
    add_double(config.glr.whiten_level);
    add_double(config.glr.whiten_tolerance);
    add((uint16_t)config.glr.whiten_first + ((uint32_t)(uint16_t)config.glr.whiten_second << 16U));
    add_double(config.moments.kurtosis_low);
    add_double(config.moments.kurtosis_high);
    add_double(config.moments.contribution_low);
    add_double(config.moments.contribution_high);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    choose_filter(&bytes);
    choose_taus(&bytes);
    if (sizes == 0U) {
        return 0;
    }
    choose_plan(&bytes);
    for (unsigned turn = 0U; (turn < 3U) && (bytes.next < bytes.end); turn++) {
        choose_result(&bytes);
        check_degrees(&bytes);
        fit(number(&bytes, -166, 166)); /* 1e-50 to 1e50 */
    }
    check_filter(&bytes);
    return 0;
}
