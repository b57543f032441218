/* davar tests - how often the detector of changes alarms without a change, and its delay after one:
 * white and other noise of known kind through lib/src/track.
 *
 *   davar-track-rates alarms NOISE HOURS PER_HOUR [BLOCK [SEED]]
 *   davar-track-rates both NOISE HOURS PER_HOUR [BLOCK [SEED]]
 *   davar-track-rates delay RATIO TRIALS PER_HOUR [BLOCK [SEED [NOISE]]]
 *   davar-track-rates check [SEED]
 *
 * NOISE: half, or one of heavy_noise.h: gauss uniform laplace student5 student4 student3 mixed
 * rare10 rare20 ar; 100 Hz, sigma 20
 * counts. both: also the second channel (clusters of 8 BLOCK), through davar.h. delay: after two
 * minutes sigma is RATIO times as large. check: tests the goals of lib/src/detector/DESIGN.md, two
 * minutes; exit status 1 if one is missed. */
#include "davar/davar.h"
#include "detector/glr.h"
#include "heavy_noise.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_HZ 100U
#define SIGMA 20.0
#define QUIET 12000U     /* samples before a step */
#define PATIENCE 100000U /* samples after it */

typedef double (*noise_t)(source_t *source);

typedef struct {
    davar_glr_t state;
    davar_glr_config_t config;
    davar_glr_event_t event;
    int32_t sum;
    uint64_t squares;
    uint32_t count;
} detector_t;

static uint64_t seed;

static double half(source_t *source)
{
    return noise_gauss(source) * 0.5 / SIGMA;
}

static noise_t noise_of(const char *name)
{
    if (strcmp(name, "half") == 0) {
        return half;
    }
    for (size_t i = 0U; i < NOISE_KINDS; i++) {
        if (strcmp(name, noise_kinds[i].name) == 0) {
            return noise_kinds[i].next;
        }
    }
    fprintf(stderr, "davar-track-rates: no such noise: %s\n", name);
    exit(2);
}

static void start(detector_t *detector, double per_hour, uint32_t block)
{
    const davar_glr_wish_t wish = {(double)RATE_HZ, per_hour, 300.0, 6000U, block, 2U, true};
    davar_glr_start(&detector->config, &wish);
    davar_glr_reset(&detector->state);
    detector->sum = 0;
    detector->squares = 0U;
    detector->count = 0U;
}

static int32_t sample_of(double value)
{
    const double rounded = floor((value * SIGMA) + 0.5);
    return (int32_t)((rounded > 32767.0) ? 32767.0 : ((rounded < -32768.0) ? -32768.0 : rounded));
}

/* True at the end of a block, which has an event. */
static bool push(detector_t *detector, double value)
{
    const int32_t sample = sample_of(value);
    detector->sum += sample;
    detector->squares += (uint64_t)((int64_t)sample * sample);
    detector->count++;
    if (detector->count < detector->config.block) {
        return false;
    }
    davar_glr_push_q15(&detector->state, &detector->config, detector->sum, detector->squares,
                       &detector->event);
    detector->sum = 0;
    detector->squares = 0U;
    detector->count = 0U;
    return true;
}

static unsigned long alarms(const char *name, double hours, double per_hour, uint32_t block)
{
    static detector_t detector;
    source_t source = source_seeded(seed);
    const noise_t noise = noise_of(name);
    unsigned long count = 0U;
    unsigned long cuts = 0U;
    unsigned long dropped = 0U;
    double f = 0.0;
    double blocks = 0.0;
    start(&detector, per_hour, block);
    const uint64_t samples = (uint64_t)(hours * 3600.0 * RATE_HZ);
    for (uint64_t i = 0U; i < samples; i++) {
        if (push(&detector, noise(&source))) {
            count += detector.event.is_alarm ? 1U : 0U;
            cuts += detector.event.is_cut ? 1U : 0U;
            dropped += detector.event.dropped;
            f += davar_glr_dispersion(&detector.state, GLR_TYPICAL) / 4096.0;
            blocks += 1.0;
        }
    }
    printf("| %s | %g | %u | %g | %lu | %.4f | %.2f | %.2f | %.2f |\n", name, per_hour,
           (unsigned)block, hours, count, (double)count / hours, (double)cuts / hours,
           (double)dropped / hours, f / blocks);
    return count;
}

static void both(const char *name, double hours, double per_hour, uint32_t block)
{
    static const uint32_t taus[] = {1U, 2U, 4U, 8U};
    static uint64_t memory[8192];
    static davar_t davar;
    davar_config_t config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    source_t source = source_seeded(seed);
    const noise_t noise = noise_of(name);
    config.law = &davar_law_glr_q15;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.rate_hz = (double)RATE_HZ;
    config.unit_per_count = 1.0;
    config.taus = taus;
    config.tau_count = 4U;
    config.window.longest = 6000U;
    config.stride = 60U;
    config.glr.false_alarms_per_hour = per_hour;
    config.glr.cut_interval_s = 300.0;
    config.glr.block = block;
    config.glr.shock_blocks = 2U;
    config.glr.long_cluster = 8U * block;
    const davar_status_t status = davar_init_q15(&davar, &config, memory, sizeof memory);
    if (status != DAVAR_OK) {
        fprintf(stderr, "davar-track-rates: %s\n", davar_status_text(status));
        exit(2);
    }
    const uint64_t samples = (uint64_t)(hours * 3600.0 * RATE_HZ);
    for (uint64_t i = 0U; i < samples; i++) {
        const int16_t sample = (int16_t)sample_of(noise(&source));
        davar_push_q15(&davar, &sample, 1U);
    }
    const davar_health_t health = davar_health(&davar);
    printf("| %s, both | %g | %u | %g | %lu | %.4f | %.2f | %.2f |\n", name, per_hour,
           (unsigned)block, hours, (unsigned long)health.alarms, health.alarms / hours,
           health.cuts / hours, health.shocks / hours);
}

static int ascending(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

/* Seconds from the step to the alarm, or PATIENCE without an alarm. */
static double delay_of(source_t *source, noise_t noise, double ratio, double per_hour,
                       uint32_t block)
{
    static detector_t detector;
    start(&detector, per_hour, block);
    const uint32_t quiet = QUIET + (uint32_t)(random_next(&source->random) % 5120U);
    for (uint32_t i = 0U; i < quiet; i++) {
        (void)push(&detector, noise(source));
    }
    for (uint32_t i = 1U; i < PATIENCE; i++) {
        if (push(&detector, ratio * noise(source)) && detector.event.is_alarm) {
            return (double)i / RATE_HZ;
        }
    }
    return (double)PATIENCE / RATE_HZ;
}

/* Prints the delays and returns their median, s. */
static double delays(const char *name, double ratio, uint32_t trials, double per_hour,
                     uint32_t block)
{
    source_t source = source_seeded(seed + 1U);
    double *const delay = malloc(trials * sizeof *delay);
    if (delay == NULL) {
        exit(1);
    }
    const noise_t noise = noise_of(name);
    double sum = 0.0;
    for (uint32_t i = 0U; i < trials; i++) {
        delay[i] = delay_of(&source, noise, ratio, per_hour, block);
        sum += delay[i];
    }
    qsort(delay, trials, sizeof *delay, ascending);
    printf("| %s x%g | %g | %u | %u | %.2f | %.2f | %.2f |\n", name, ratio, per_hour,
           (unsigned)block, (unsigned)trials, sum / trials, delay[trials / 2U],
           delay[(trials * 9U) / 10U]);
    const double median = delay[trials / 2U];
    free(delay);
    return median;
}

static bool is_within(const char *noise, const char *what, double value, double most)
{
    if (value > most) {
        fprintf(stderr, "davar-track-rates: %s: %s: %.2f, expected at most %.2f\n", noise, what,
                value, most);
    }
    return value <= most;
}

/* Limits: 1.5 times the configured alarms, and 1.3 times the median delay without the last term of
 * (10.3). lib/src/detector/DESIGN.md has these medians. */
static int check(void)
{
    static const struct {
        const char *noise;
        double x1_5_s;
        double x2_s;
    } delay[] = {{"gauss", 1.04, 0.40},   {"laplace", 2.44, 0.87}, {"student5", 2.58, 0.85},
                 {"student3", 7.9, 2.27}, {"mixed", 10.2, 3.63},   {"ar", 1.59, 0.53}};
    bool good = true;
    for (size_t i = 0U; i < sizeof delay / sizeof delay[0]; i++) {
        const char *const noise = delay[i].noise;
        const double found = (double)alarms(noise, 400.0, 0.1, 10U);
        good = is_within(noise, "alarms at 0.1 per hour", found, 60.0) && good;
        const double after_x1_5 = delays(noise, 1.5, 2000U, 0.01, 10U);
        const double after_x2 = delays(noise, 2.0, 2000U, 0.01, 10U);
        good = is_within(noise, "delay after x1.5", after_x1_5, 1.3 * delay[i].x1_5_s) && good;
        good = is_within(noise, "delay after x2", after_x2, 1.3 * delay[i].x2_s) && good;
    }
    static const char *const rarely[] = {"student5", "student3"}; /* the most alarms */
    for (size_t i = 0U; i < sizeof rarely / sizeof rarely[0]; i++) {
        const double found = (double)alarms(rarely[i], 4000.0, 0.01, 10U);
        good = is_within(rarely[i], "alarms at 0.01 per hour", found, 60.0) && good;
    }
    return good ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (((argc == 2) || (argc == 3)) && (strcmp(argv[1], "check") == 0)) {
        seed = (argc == 3) ? strtoull(argv[2], NULL, 10) : 1U;
        return check();
    }
    if (argc < 5) {
        fputs("usage: davar-track-rates alarms|both NOISE HOURS PER_HOUR [BLOCK [SEED]] | delay "
              "RATIO TRIALS PER_HOUR [BLOCK [SEED [NOISE]]] | check [SEED]\n",
              stderr);
        return 2;
    }
    const uint32_t block = (argc > 5) ? (uint32_t)strtoul(argv[5], NULL, 10) : 10U;
    const double per_hour = strtod(argv[4], NULL);
    seed = (argc > 6) ? strtoull(argv[6], NULL, 10) : 1U;
    if (strcmp(argv[1], "alarms") == 0) {
        (void)alarms(argv[2], strtod(argv[3], NULL), per_hour, block);
    } else if (strcmp(argv[1], "both") == 0) {
        both(argv[2], strtod(argv[3], NULL), per_hour, block);
    } else {
        (void)delays((argc > 7) ? argv[7] : "gauss", strtod(argv[2], NULL),
                     (uint32_t)strtoul(argv[3], NULL, 10), per_hour, block);
    }
    return 0;
}
