/* davar tests - chains of calls of a cascade: any settings, samples in any pieces, gaps, faults of
 * floats, flush, reset, save and restore, append and fit. A second cascade of the same samples, in
 * other pieces and never saved, has the same bits, and every lost sample is counted. */
#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/state.h"
#include "digest.h"
#include "fuzzing.h"
#include "random.h"

#include <math.h>
#include <string.h>

#define TAUS DAVAR_CASCADE_TAUS_MAX
#define BYTES DAVAR_CASCADE_MEMORY(F32, TAUS)
#define BLOCK_MAX 4096U
#define SLOT (BYTES + 200U)

#include "cells.h"

static davar_cascade_config_t config;
static type_t type;
static davar_cascade_t cascades[2];
static uint64_t memory[2][BYTES / 8U];
static davar_cascade_health_t expected;
static bool in_gap; /* floats: the newest sample was not finite */
static int16_t narrow[BLOCK_MAX];
static int32_t wide[BLOCK_MAX];
static float rates[BLOCK_MAX];
static davar_result_t results[2];

/* --- settings --- */

static void choose(bytes_t *bytes)
{
    type = (type_t)between(bytes, 0U, 2U);
    config = (davar_cascade_config_t){.rate_hz = 100.0, .unit_per_count = 0.01};
    config.full_scale = 300.0;
    const uint32_t largest = (byte(bytes) < 8U) ? 255U : 8U;
    config.shortest = 64U + (4U * between(bytes, 0U, largest));
    config.tau_count = (uint8_t)between(bytes, 0U, TAUS + 1U);
    config.clusters = (uint16_t)(1U << between(bytes, 1U, 12U));
    config.clusters = (uint16_t)(config.clusters + ((byte(bytes) < 4U) ? 1U : 0U));
}

static davar_cascade_status_t init(unsigned which)
{
    static davar_cascade_status_t (*const inits[])(
        davar_cascade_t *, const davar_cascade_config_t *, void *,
        size_t) = {davar_cascade_init_q15, davar_cascade_init_q31, davar_cascade_init_f32};
    memset(memory[which], 0xA5, sizeof memory[which]);
    return inits[type](&cascades[which], &config, memory[which], sizeof memory[which]);
}

/* --- samples --- */

/* Noise of some level, with a walk, a constant or rails; of floats also what is not a number. */
static void fill(bytes_t *bytes, size_t count)
{
    const uint32_t shift = between(bytes, 0U, 30U);
    const uint8_t kind = byte(bytes);
    random_t random = random_seeded(byte(bytes));
    int32_t walk = 0;
    for (size_t i = 0U; i < count; i++) {
        const int32_t noise = (int32_t)((uint32_t)(random_next(&random) >> 33U)) - 0x40000000;
        walk += noise >> (shift / 2U + 12U);
        int32_t value = (noise >> shift) + (((kind % 4U) == 1U) ? walk / 4 : 0);
        value = (kind >= 240U) ? ((noise < 0) ? INT32_MIN : INT32_MAX) : value;
        value = ((kind >= 224U) && (kind < 240U)) ? (int32_t)(shift * 1000U) : value;
        wide[i] = value;
        narrow[i] = (int16_t)(value / 65536);
        rates[i] = (float)value * (400.0F / 2147483648.0F);
        if ((kind >= 200U) && (kind < 224U) && ((random_next(&random) % 64U) < 3U)) {
            rates[i] = ((random_next(&random) % 2U) == 0U) ? NAN : INFINITY;
        }
    }
}

static void push(davar_cascade_t *cascade, size_t from, size_t count)
{
    if (type == Q15) {
        davar_cascade_push_q15(cascade, &narrow[from], count);
    } else if (type == Q31) {
        davar_cascade_push_q31(cascade, &wide[from], count);
    } else {
        davar_cascade_push_f32(cascade, &rates[from], count);
    }
}

static void expect_faults(size_t count)
{
    for (size_t i = 0U; (type == F32) && (i < count); i++) {
        const bool is_finite = isfinite(rates[i]) != 0;
        expected.gaps += (!is_finite && !in_gap) ? 1U : 0U;
        expected.missing += is_finite ? 0U : 1U;
        expected.not_finite += is_finite ? 0U : 1U;
        expected.saturated += (is_finite && (fabsf(rates[i]) >= 300.0F)) ? 1U : 0U;
        in_gap = !is_finite;
    }
}

/* The first takes whole blocks, the second pieces. Many times: a size is thousands of samples. */
static void push_block(bytes_t *bytes)
{
    const size_t size = byte(bytes);
    const size_t count = 1U + ((size * byte(bytes)) % BLOCK_MAX);
    const size_t piece = 1U + between(bytes, 0U, 99U);
    const uint32_t turns = between(bytes, 1U, 8U);
    fill(bytes, count);
    for (uint32_t turn = 0U; turn < turns; turn++) {
        push(&cascades[0], 0U, count);
        for (size_t done = 0U; done < count; done += piece) {
            push(&cascades[1], done, ((count - done) < piece) ? (count - done) : piece);
        }
        expect_faults(count);
    }
}

static void lose(bytes_t *bytes)
{
    const uint32_t lost = between(bytes, 1U, 200U);
    davar_cascade_gap(&cascades[0], lost);
    davar_cascade_gap(&cascades[1], lost);
    expected.gaps++;
    expected.missing += lost;
    in_gap = false;
}

static void through_the_dark(bytes_t *bytes)
{
    (void)bytes;
    REQUIRE(davar_cascade_state_bytes(&cascades[0]) <= SLOT);
    REQUIRE(davar_cascade_save(&cascades[0], &storage) == DAVAR_STATE_OK);
    REQUIRE(init(0U) == DAVAR_CASCADE_OK);
    REQUIRE(davar_cascade_restore(&cascades[0], &storage) == DAVAR_STATE_OK);
}

static void reset(void)
{
    davar_cascade_reset(&cascades[0]);
    davar_cascade_reset(&cascades[1]);
    memset(&expected, 0, sizeof expected);
    in_gap = false;
}

/* --- results --- */

static void check_health(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        const davar_cascade_health_t health = davar_cascade_health(&cascades[i]);
        REQUIRE((health.gaps == expected.gaps) && (health.missing == expected.missing));
        REQUIRE(health.not_finite == expected.not_finite);
        REQUIRE(health.saturated == expected.saturated);
    }
}

static void check_tau(uint8_t t)
{
    const davar_adev_t *const tau = &results[0].tau[t];
    const davar_adev_t *const other = &results[1].tau[t];
    REQUIRE((tau->m == (config.shortest << t)) && (tau->m == other->m));
    REQUIRE(tau->differences == other->differences);
    REQUIRE((isnan(tau->adev) && isnan(other->adev)) ||
            ((tau->adev <= other->adev) && (tau->adev >= other->adev)));
    REQUIRE((tau->hops == 4U) || (tau->hops == 8U));
    REQUIRE((tau->differences > 0U) ? is_number(tau->adev) : (isnan(tau->adev) != 0));
    REQUIRE((tau->power >= 0.0F) && isfinite(tau->power));
    add(tau->differences + ((uint64_t)tau->uneven << 32U));
    add_double(tau->adev);
    add_float(tau->power);
}

static void check_fit(bytes_t *bytes)
{
    static uint32_t sizes[TAUS];
    davar_plan_t plan;
    for (uint8_t t = 0U; t < results[0].tau_count; t++) {
        sizes[t] = results[0].tau[t].m;
    }
    if (byte(bytes) % 2U == 0U) {
        davar_plan_init_white(&plan, sizes, results[0].tau_count);
    } else {
        davar_plan_init(&plan, sizes, results[0].tau_count);
    }
    davar_fit(&plan, config.rate_hz, &results[0]);
    for (int kind = 0; kind < (int)DAVAR_COEFFICIENT_COUNT; kind++) {
        const davar_coefficient_t *const coefficient = &results[0].coefficient[kind];
        check_coefficient(coefficient);
        add_double(coefficient->value);
        add_double(coefficient->low);
        add_double(coefficient->high);
    }
}

static void append(bytes_t *bytes)
{
    memset(results, 0, sizeof results);
    const bool has = davar_cascade_append(&cascades[0], &results[0]);
    REQUIRE(has == davar_cascade_append(&cascades[1], &results[1]));
    REQUIRE(results[0].tau_count == results[1].tau_count);
    REQUIRE(results[0].tau_count == config.tau_count);
    for (uint8_t t = 0U; t < results[0].tau_count; t++) {
        check_tau(t);
    }
    if (has && (byte(bytes) % 4U == 0U)) {
        check_fit(bytes);
    }
}

static void reset_at_times(bytes_t *bytes)
{
    if (byte(bytes) < 64U) {
        reset();
    }
}

static void flush(bytes_t *bytes)
{
    (void)bytes;
    davar_cascade_flush(&cascades[0]);
    davar_cascade_flush(&cascades[1]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const actions[])(bytes_t *) = {
        lose, through_the_dark, flush, reset_at_times, append, append, push_block};
    bytes_t bytes = {data, data + size};
    choose(&bytes);
    const davar_cascade_status_t status = init(0U);
    REQUIRE(strlen(davar_cascade_status_text(status)) > 0U);
    add((uint64_t)status);
    if (status != DAVAR_CASCADE_OK) {
        return 0;
    }
    REQUIRE(init(1U) == DAVAR_CASCADE_OK);
    memset(cells, 0, sizeof cells);
    reset();
    while (bytes.next < bytes.end) {
        const uint8_t action = byte(&bytes) % 16U;
        actions[(action < 6U) ? action : 6U](&bytes);
        check_health();
    }
    return 0;
}
