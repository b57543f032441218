/* davar tests - the floor with any plan and samples, gaps and results that nobody takes: every limit
 * is a number or absent for a reason, and a refused plan changes nothing. */
#include "davar/filter.h"
#include "davar/floor.h"
#include "digest.h"
#include "fuzzing.h"
#include "random.h"

#include <math.h>
#include <string.h>

static davar_floor_plan_t plan;
static davar_floor_t axis;
static davar_floor_result_t result;

static bool make_plan(bytes_t *bytes)
{
    unsigned char before[sizeof plan];
    davar_filter_t filter = {.b = {0.0}};
    davar_floor_config_t config = {.rate_hz = (double)word(bytes, 2U)};
    config.unit_per_count = (double)word(bytes, 2U) / 1024.0;
    config.rail = (int32_t)(uint32_t)word(bytes, 4U);
    config.block = (uint16_t)(32U * between(bytes, 0U, 16U));
    const uint8_t kind = byte(bytes);
    if (kind > 128U) {
        davar_filter_biquad(&filter, (double)kind / 512.0);
        config.filter = &filter;
    } else if (kind > 120U) {
        filter.a[1] = 7.0; /* not valid */
        config.filter = &filter;
    } else {
        /* none */
    }
    memset(&plan, 0xA5, sizeof plan);
    memcpy(before, &plan, sizeof before);
    const davar_floor_status_t status = davar_floor_plan(&plan, &config);
    REQUIRE(strlen(davar_floor_status_text(status)) > 0U);
    REQUIRE((status == DAVAR_FLOOR_OK) ||
            (memcmp(before, (const unsigned char *)&plan, sizeof before) == 0));
    return status == DAVAR_FLOOR_OK;
}

static void check_floor_result(void)
{
    const bool has_value = (result.why == DAVAR_FLOOR_VALUE);
    REQUIRE(strlen(davar_floor_why_text(result.why)) > 0U);
    REQUIRE(has_value == (isnan(result.value) == 0));
    REQUIRE(has_value == (isnan(result.low) == 0));
    REQUIRE(!(result.low < 0.0F) && (result.high >= 0.0F));
    REQUIRE(!has_value || ((result.low <= result.value) && (result.value <= result.high)));
    REQUIRE((result.share >= 0.0F) && (result.share <= 1.0F));
    REQUIRE((result.where >= 0.0F) && (result.where < 0.5F));
    REQUIRE(result.unsteady >= 0.0F);
    add_float(result.high);
    add((uint64_t)result.why + result.shocks + result.clipped);
}

/* Noise of a size, a stuck sensor, any bits or a gap, for up to 256 samples. */
static void run_floor(bytes_t *bytes, random_t *random)
{
    const uint8_t kind = byte(bytes) % 8U;
    const uint32_t count = between(bytes, 1U, 256U);
    const double size = (double)((uint32_t)1U << (byte(bytes) % 31U));
    for (uint32_t n = 0U; n < count; n++) {
        const double noise = size * random_gauss(random);
        int32_t sample = (int32_t)fmin(fmax(noise, -2147483648.0), 2147483647.0);
        if (kind == 0U) {
            sample = 7;
        } else if (kind == 1U) {
            sample = (int32_t)(uint32_t)word(bytes, 4U);
        } else if ((kind == 2U) && (n == 0U)) {
            davar_floor_gap(&axis);
        } else if ((kind == 4U) && (n == 0U)) {
            davar_floor_delay(&axis, byte(bytes) % 32U);
        } else {
            /* noise */
        }
        if (davar_floor_push(&axis, &plan, sample) && (kind != 3U)) {
            davar_floor_take(&axis, &plan, &result);
            check_floor_result();
        }
    }
}

static davar_floor_flight_t flight;
static davar_floor_baseline_t baseline;

/* A window joins the flight; at times the flight ends. */
static void fly(bytes_t *bytes)
{
    davar_floor_change_t change;
    const uint8_t kind = byte(bytes);
    davar_floor_flight_add(&flight, kind % DAVAR_FLOOR_BANDS, &result);
    davar_floor_compare(&baseline, &flight, &change);
    REQUIRE(change.is_known == (isnan(change.factor) == 0));
    REQUIRE(!change.is_known || ((change.low <= change.factor) && (change.factor <= change.high)));
    if (kind > 240U) {
        davar_floor_baseline_add(&baseline, &flight);
        memset(&flight, 0, sizeof flight);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    random_t random = random_seeded(word(&bytes, 2U));
    if (make_plan(&bytes)) {
        davar_floor_start(&axis);
        memset(&flight, 0, sizeof flight);
        memset(&baseline, 0, sizeof baseline);
        davar_floor_take(&axis, &plan, &result);
        check_floor_result();
        while (bytes.next < bytes.end) {
            run_floor(&bytes, &random);
            fly(&bytes);
        }
    }
    return 0;
}
