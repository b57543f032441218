/* davar tests - how long a gyro must rest until the fit of a window and a cascade resolves its bias
 * instability and its rate random walk. Prints the table of docs/FIRMWARE.md; fixed seeds. */
#include "davar/cascade.h"
#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define RATE_HZ 100.0
#define LSB (250.0 / 32768.0) /* deg/s */
#define MINUTE 6000U          /* samples; a window, and from one result to the next */
#define SECOND 100U
#define TAUS 7U
#define LONG_TAUS 17U /* up to a day */
#define RECORDINGS 200U

/* Gauss-Markov processes of one variance, a factor of four apart in time, add up to flicker; from
 * 1 s to 186 days. Shorter ones are below the white noise. */
#define MARKOV_COUNT 13
#define MARKOV_FIRST_S 1.0

typedef struct {
    double n;          /* deg/sqrt(h) */
    double b;          /* deg/h */
    double k;          /* deg/h/sqrt(h) */
    unsigned most_min; /* length of a recording */
} gyro_t;

typedef struct {
    random_t random;
    double markov[MARKOV_COUNT];
    double memory[MARKOV_COUNT]; /* of a second */
    double sigma;                /* of each process, in counts */
    double white;                /* of a sample */
    double step;                 /* of the walk in a second */
    double walk;
} noise_t;

static const uint32_t sizes[TAUS + LONG_TAUS] = {
    1U,     2U,      4U,      8U,      16U,      32U,      64U,      128U,
    256U,   512U,    1024U,   2048U,   4096U,    8192U,    16384U,   32768U,
    65536U, 131072U, 262144U, 524288U, 1048576U, 2097152U, 4194304U, 8388608U};
static const davar_cascade_config_t long_config = {.rate_hz = RATE_HZ,
                                                   .unit_per_count = LSB,
                                                   .shortest = 128U,
                                                   .tau_count = LONG_TAUS,
                                                   .clusters = 32U};
static davar_config_t config;
static uint64_t memory[512];
static uint64_t stages[DAVAR_CASCADE_MEMORY(Q15, LONG_TAUS) / 8U];
static davar_t davar;
static davar_cascade_t cascade;
static davar_plan_t plan;
static davar_result_t result;
void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = LSB;
    config.law = NULL;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.window.grow = 1U;
    config.window.longest = MINUTE;
    config.window.shortest = MINUTE;
    config.moments.segment = 0U;
    config.stride = MINUTE;
    config.engine = DAVAR_ENGINE_GRID;
    config.taus = sizes;
    config.tau_count = TAUS;
    davar_plan_init_white(&plan, sizes, TAUS + LONG_TAUS);
}

void tearDown(void) {}

static noise_t start_noise(const gyro_t *gyro, uint64_t seed)
{
    noise_t noise = {.random = random_seeded(seed),
                     .sigma = gyro->b / 3600.0 * sqrt(2.0 * log(2.0) / acos(-1.0)) / LSB,
                     .white = gyro->n / 60.0 * sqrt(RATE_HZ) / LSB,
                     .step = gyro->k / 3600.0 / 60.0 / LSB};
    for (int i = 0; i < MARKOV_COUNT; i++) {
        noise.memory[i] = exp(-1.0 / (MARKOV_FIRST_S * pow(4.0, i)));
        noise.markov[i] = noise.sigma * random_gauss(&noise.random);
    }
    return noise;
}

/* The slow terms keep their value for a second. The white noise is not quite Gaussian, which B
 * and K do not notice. */
static void fill_second(noise_t *noise, int16_t *counts)
{
    double slow = noise->walk;
    for (int i = 0; i < MARKOV_COUNT; i++) {
        const double rest = sqrt(1.0 - noise->memory[i] * noise->memory[i]);
        noise->markov[i] =
            noise->memory[i] * noise->markov[i] + noise->sigma * rest * random_bell(&noise->random);
        slow += noise->markov[i];
    }
    noise->walk += noise->step * random_gauss(&noise->random);
    for (uint32_t i = 0U; i < SECOND; i++) {
        const double above = slow + noise->white * random_bell(&noise->random) + 32768.5;
        counts[i] = (int16_t)((int32_t)above - 32768);
    }
}

/* Times at which the fit is tested: ten per decade, in minutes, up to three days. */
#define CHECKS 31U
static const unsigned check_min[CHECKS] = {4U,    5U,    6U,    8U,    10U,   13U,   16U,  20U,
                                           25U,   32U,   40U,   50U,   63U,   79U,   100U, 126U,
                                           158U,  200U,  251U,  316U,  398U,  501U,  631U, 794U,
                                           1000U, 1259U, 1585U, 1995U, 2512U, 3162U, 3981U};

/* Of all recordings of a gyro, at each of these times. */
typedef struct {
    unsigned resolved[CHECKS];
    unsigned true_in[CHECKS]; /* the interval, or the upper limit, contains the truth */
} shares_t;

static void check(const gyro_t *gyro, davar_coefficient_kind_t kind, unsigned i, shares_t *shares)
{
    const double truth = (kind == DAVAR_BIAS_INSTABILITY) ? gyro->b : gyro->k;
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_TRUE(davar_cascade_append(&cascade, &result));
    davar_fit(&plan, RATE_HZ, &result);
    const davar_coefficient_t *const found = &result.coefficient[kind];
    shares->resolved[i] += found->present ? 1U : 0U;
    shares->true_in[i] +=
        ((truth <= found->high) && (!found->present || (truth >= found->low))) ? 1U : 0U;
}

static void watch(const gyro_t *gyro, davar_coefficient_kind_t kind, uint64_t seed,
                  shares_t *shares)
{
    noise_t noise = start_noise(gyro, seed);
    int16_t counts[SECOND];
    unsigned minute = 0U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_OK,
                      davar_cascade_init_q15(&cascade, &long_config, stages, sizeof stages));
    for (unsigned i = 0U; (i < CHECKS) && (check_min[i] <= gyro->most_min); i++) {
        for (; minute < check_min[i]; minute++) {
            const bool in_window = (minute + 1U == check_min[i]); /* which has only this minute */
            for (uint32_t s = 0U; s < 60U; s++) {
                fill_second(&noise, counts);
                davar_push_q15(&davar, counts, in_window ? SECOND : 0U);
                davar_cascade_push_q15(&cascade, counts, SECOND);
            }
        }
        check(gyro, kind, i, shares);
    }
}

/* The first time at which so many recordings resolve the coefficient, in minutes; infinite: none. */
static double time_of(const shares_t *shares, unsigned recordings)
{
    for (unsigned i = 0U; i < CHECKS; i++) {
        if (shares->resolved[i] >= recordings) {
            return check_min[i];
        }
    }
    return (double)INFINITY;
}

static void print_time(double minutes)
{
    if (!isfinite(minutes)) {
        printf(" - |");
    } else if (minutes < 100.0) {
        printf(" %.0f min |", minutes);
    } else {
        printf(" %.1f h |", minutes / 60.0);
    }
}

/* Prints a row of the table; returns when half of the recordings resolve the coefficient. */
static double row(const char *name, gyro_t gyro, davar_coefficient_kind_t kind)
{
    shares_t shares = {{0U}, {0U}};
    for (unsigned n = 0U; n < RECORDINGS; n++) {
        watch(&gyro, kind, 1000U + n, &shares);
    }
    const double half = time_of(&shares, RECORDINGS / 2U);
    printf("| %s | %.2g | %.2g | %.2g |", name, gyro.n, gyro.b, gyro.k);
    print_time(half);
    print_time(time_of(&shares, (RECORDINGS * 9U) / 10U));
    unsigned least = RECORDINGS;
    for (unsigned i = 0U; (i < CHECKS) && (check_min[i] <= gyro.most_min); i++) {
        least = (shares.true_in[i] < least) ? shares.true_in[i] : least;
    }
    printf(" %.0f |\n", 100.0 * least / RECORDINGS);
    (void)fflush(stdout);
    TEST_ASSERT_TRUE_MESSAGE(100U * least >= 88U * RECORDINGS, name); /* 94 and four errors */
    return half;
}

/* Data sheets give N and the in-run bias stability, not K. */
static void test_bias_instability_is_resolved_in_time(void)
{
    const davar_coefficient_kind_t kind = DAVAR_BIAS_INSTABILITY;
    (void)row("ADIS16470", (gyro_t){0.34, 8.0, 0.0, 100U}, kind);
    (void)row("ADIS16488A", (gyro_t){0.26, 5.1, 0.0, 100U}, kind);
    (void)row("ADIS16505-1", (gyro_t){0.13, 2.3, 0.0, 100U}, kind);
    TEST_ASSERT_TRUE(row("0.3 and 5", (gyro_t){0.3, 5.0, 0.0, 100U}, kind) <= 60.0);
    (void)row("ADIS16405", (gyro_t){2.0, 25.0, 0.0, 200U}, kind);
    (void)row("ADIS16495-1", (gyro_t){0.09, 0.8, 0.0, 400U}, kind);
    (void)row("BMI088", (gyro_t){0.84, 2.0, 0.0, 2600U}, kind);
    (void)row("STIM300", (gyro_t){0.15, 0.3, 0.0, 2600U}, kind);
}

static void test_rate_random_walk_is_resolved_in_time(void)
{
    const davar_coefficient_kind_t kind = DAVAR_RATE_RANDOM_WALK;
    TEST_ASSERT_TRUE(row("any", (gyro_t){0.3, 5.0, 20.0, 800U}, kind) <= 720.0);
    (void)row("any", (gyro_t){0.3, 5.0, 10.0, 2000U}, kind);
    (void)row("any", (gyro_t){0.3, 5.0, 5.0, 4000U}, kind);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_bias_instability_is_resolved_in_time);
    RUN_TEST(test_rate_random_walk_is_resolved_in_time);
    return UNITY_END();
}
