/* davar tests - a selection of gyros with any settings and rates, missing and stuck ones among
 * them: weights are shares, the chosen gyro exists, and a refused setting changes nothing. */
#include "davar/select.h"
#include "digest.h"
#include "fuzzing.h"
#include "random.h"

#include <math.h>
#include <string.h>

#define GYROS DAVAR_SELECT_GYROS
#define AXES DAVAR_SELECT_AXES
#define FAULTS (DAVAR_SELECT_ABSENT | DAVAR_SELECT_STUCK | DAVAR_SELECT_MEAN | DAVAR_SELECT_NOISE)

static davar_select_config_t config;
static davar_select_t selection;
static davar_select_gyro_t gyros[GYROS];
static davar_select_pair_t pairs[DAVAR_SELECT_PAIRS(GYROS)];
static davar_select_verdict_t verdict;
static uint32_t samples; /* of the block */
static uint8_t chosen;

/* Usually a number of the range, at times any bits. */
static float setting(bytes_t *bytes, float low, float high)
{
    if (byte(bytes) >= 4U) {
        return low + ((high - low) * ((float)byte(bytes) / 255.0F));
    }
    const uint32_t bits = (uint32_t)word(bytes, 4U);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void choose(bytes_t *bytes)
{
    config = (davar_select_config_t){DAVAR_SELECT_DEFAULTS};
    config.gyros = (uint8_t)between(bytes, 2U, GYROS);
    config.axes = (uint8_t)between(bytes, 1U, AXES);
    config.block = (uint16_t)between(bytes, 4U, 40U);
    if (byte(bytes) < 8U) {
        config.gyros = byte(bytes);
        config.axes = byte(bytes);
        config.block = byte(bytes);
    }
    config.rate_hz = setting(bytes, 4.0F * config.block, 25.0F * config.block);
    config.errors_per_1000_h = setting(bytes, 0.001F, 1e6F);
    config.scale_tolerance = setting(bytes, 0.0001F, 1.0F);
    config.time_tolerance_s = setting(bytes, 1e-6F, 1.0F);
    config.drift_tolerance_dps_per_s = setting(bytes, 1e-6F, 1.0F);
}

static bool start(void)
{
    unsigned char before[sizeof selection];
    memset(&selection, 0xA5, sizeof selection);
    memset(gyros, 0xA5, sizeof gyros);
    memset(pairs, 0xA5, sizeof pairs);
    memcpy(before, &selection, sizeof before);
    const davar_select_status_t status = davar_select_init(&selection, &config, gyros, pairs);
    const bool starts = (status == DAVAR_SELECT_OK);
    REQUIRE(strlen(davar_select_status_text(status)) > 0U);
    REQUIRE(starts || (memcmp(before, (const unsigned char *)&selection, sizeof before) == 0));
    samples = 0U;
    chosen = 0U;
    return starts;
}

static void check_verdict(void)
{
    float sum = 0.0F;
    REQUIRE(verdict.chosen < config.gyros);
    REQUIRE(verdict.switched == (verdict.chosen != chosen));
    chosen = verdict.chosen;
    bool usable = false;
    for (uint8_t i = 0U; i < config.gyros; i++) {
        const uint8_t fault = verdict.fault[i];
        const bool is_out =
            (fault & (DAVAR_SELECT_ABSENT | DAVAR_SELECT_STUCK | DAVAR_SELECT_MEAN)) != 0U;
        REQUIRE((verdict.weight[i] >= 0.0F) && (verdict.weight[i] <= 1.0F));
        REQUIRE((fault & ~FAULTS) == 0U);
        REQUIRE(!is_out || !(verdict.weight[i] > 0.0F));
        REQUIRE((config.gyros > 2U) || ((fault & DAVAR_SELECT_MEAN) == 0U));
        usable = usable || !is_out;
        sum += verdict.weight[i];
        add_float(verdict.weight[i]);
        add(fault);
    }
    REQUIRE(verdict.usable == usable);
    REQUIRE(usable ? (fabsf(sum - 1.0F) < 1e-5F) : !(sum > 0.0F));
    add(verdict.chosen + (verdict.switched ? 8U : 0U) + (verdict.disagree ? 16U : 0U) +
        (verdict.hidden ? 32U : 0U));
}

/* Blocks of common motion, noise and bias of each gyro; some gyros miss samples, stick, jump or
 * have huge rates. */
static void add_samples(bytes_t *bytes)
{
    static float stuck[GYROS * AXES];
    float noise[GYROS];
    float bias[GYROS];
    uint8_t what[GYROS];
    float rates[GYROS * AXES];
    const uint32_t more = byte(bytes) % 5U;
    const uint32_t count = (config.block * between(bytes, 1U, 40U)) + more;
    const float motion = ldexpf(1.0F, (int)between(bytes, 0U, 24U) - 12);
    random_t random = random_seeded(byte(bytes));
    for (uint8_t i = 0U; i < config.gyros; i++) {
        noise[i] = ldexpf(1.0F, (int)between(bytes, 0U, 40U) - 20);
        const int exponent = (int)between(bytes, 0U, 10U) - 8;
        bias[i] = ldexpf((float)byte(bytes) - 128.0F, exponent);
        what[i] = byte(bytes);
    }
    for (uint32_t k = 0U; k < count; k++) {
        float common = 0.0F;
        for (unsigned at = 0U; at < (unsigned)config.gyros * config.axes; at++) {
            const unsigned i = at / config.axes;
            const uint64_t bits = random_next(&random);
            common =
                ((at % config.axes) == 0U) ? motion * ((float)((k + i) % 32U) - 16.0F) : common;
            rates[at] =
                common + bias[i] +
                (noise[i] * (float)((int64_t)(bits >> 40U) - 8388608) * (1.0F / 8388608.0F));
            rates[at] = (what[i] == 255U) ? stuck[at] : rates[at];
            rates[at] =
                ((what[i] >= 240U) && (what[i] < 248U) && ((bits & 63U) < 4U)) ? NAN : rates[at];
            rates[at] = (what[i] == 254U) ? NAN : rates[at];
            rates[at] = ((what[i] == 253U) && ((bits & 63U) == 0U)) ? 3e38F : rates[at];
            rates[at] = (what[i] == 252U) ? -INFINITY : rates[at];
            stuck[at] = isfinite(rates[at]) ? rates[at] : 0.0F;
        }
        const bool complete = davar_select_add(&selection, rates);
        samples++;
        REQUIRE(complete == (samples == config.block));
        if (complete) {
            davar_select_update(&selection, &verdict);
            check_verdict();
            samples = 0U;
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    choose(&bytes);
    const bool starts = start();
    add(starts ? 1U : 0U);
    while (starts && (bytes.next < bytes.end)) {
        add_samples(&bytes);
    }
    return 0;
}
