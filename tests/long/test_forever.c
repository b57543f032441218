/* davar tests - 10^7 samples of bursts, rails, gaps and window changes: every epoch is compared
 * with sums recomputed from the record, bit for bit. These sums are 64-bit integers over a
 * cumulative sum, a different method than the library's. */
#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <math.h>

#ifndef FOREVER_SAMPLES
#define FOREVER_SAMPLES 10000000U
#endif
#define TAUS 5U
#define RING 256U /* of the record; a power of two above the window */

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static uint64_t memory[2048];
static int64_t phase[RING]; /* cumulative sums at sample n, modulo RING */
static uint32_t run[RING];  /* samples without a gap up to sample n */
static davar_config_t config;

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 1.0;
    config.unit_per_count = 1.0;
    config.window.longest = 96U;
    config.window.shortest = 40U;
    config.moments.segment = 16U;
    config.window.gaps_max = 200U;
    config.taus = taus;
    config.tau_count = TAUS;
}

void tearDown(void) {}

static int16_t next_sample(random_t *random, uint32_t n)
{
    const uint32_t kind = (n / 500U) % 7U;
    const uint64_t bits = random_next(random);
    switch (kind) {
    case 2U:
        return ((bits & 1U) != 0U) ? INT16_MAX : INT16_MIN;
    case 4U:
        return INT16_MIN;
    case 6U:
        return (int16_t)(bits & 0xFFFFU);
    default:
        return (int16_t)((int32_t)(bits % 41U) - 20 + (int32_t)(n % 997U));
    }
}

/* Sum of D^2 over [tail, head) and its count, from cumulative sums: D = P[i] - 2 P[i - m] + P[i - 2
 * m]. */
static uint64_t window_sum(uint64_t tail, uint64_t head, uint32_t m, uint32_t *differences)
{
    uint64_t sum = 0U;
    *differences = 0U;
    for (uint64_t last = tail + (UINT64_C(2) * m) - 1U; last < head; last++) {
        if (run[last % RING] >= (2U * m)) {
            const int64_t before = phase[(last - (UINT64_C(2) * m)) % RING];
            const int64_t d = phase[last % RING] - (2 * phase[(last - m) % RING]) + before;
            sum += (uint64_t)(d * d);
            (*differences)++;
        }
    }
    return sum;
}

static void check(const davar_result_t *result, uint64_t head)
{
    const uint64_t tail = head - result->window_samples;
    for (uint32_t t = 0U; t < TAUS; t++) {
        uint32_t differences = 0U;
        const double m = (double)taus[t];
        const uint64_t sum = window_sum(tail, head, taus[t], &differences);
        if (differences != result->tau[t].differences) {
            TEST_ASSERT_EQUAL_UINT32(differences, result->tau[t].differences);
        }
        if (differences > 0U) {
            const double expected = sqrt((double)sum / (2.0 * m * m * (double)differences));
            if ((expected < result->tau[t].adev) || (expected > result->tau[t].adev)) {
                TEST_ASSERT_EQUAL_DOUBLE(expected, result->tau[t].adev);
            }
        }
    }
}

static void run_forever(davar_mode_t mode, uint32_t samples)
{
    davar_t davar;
    davar_result_t result;
    random_t random = random_seeded(3U);
    config.window.mode = mode;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    uint64_t checked = 0U;
    uint32_t shortest = config.window.longest;
    for (uint32_t n = 0U; n < samples; n++) {
        const int16_t sample = next_sample(&random, n);
        const bool gap =
            (n > 0U) && (((n / 3000U) % 3U) == 1U) && ((random_next(&random) % 50U) == 0U);
        if (gap) {
            davar_gap(&davar, 1U);
        }
        phase[n % RING] = ((n > 0U) ? phase[(n - 1U) % RING] : 0) + sample;
        run[n % RING] = (gap || (n == 0U)) ? 1U : (run[(n - 1U) % RING] + 1U);
        davar_push_q15(&davar, &sample, 1U);
        if (!davar_take(&davar, &result)) {
            continue;
        }
        shortest = (result.window_samples < shortest) ? result.window_samples : shortest;
        const bool centred = (mode == DAVAR_MODE_CENTRED);
        const uint64_t head = result.epoch + (centred ? (result.window_samples / 2U) : 1U);
        if (head > result.window_samples) { /* the property test covers the mirrored start */
            check(&result, head);
            checked++;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT64(samples - 200U, checked);
    TEST_ASSERT_EQUAL_UINT32(config.window.shortest, shortest);
}

static void test_every_epoch_of_ten_million_samples_is_exact_in_trailing_mode(void)
{
    run_forever(DAVAR_MODE_TRAILING, FOREVER_SAMPLES);
}

static void test_every_epoch_of_a_million_samples_is_exact_in_centred_mode(void)
{
    run_forever(DAVAR_MODE_CENTRED, FOREVER_SAMPLES / 10U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_epoch_of_ten_million_samples_is_exact_in_trailing_mode);
    RUN_TEST(test_every_epoch_of_a_million_samples_is_exact_in_centred_mode);
    return UNITY_END();
}
