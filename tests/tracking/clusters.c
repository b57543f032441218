/* davar tests - the second channel, which detects changes of clusters: how often it alarms without
 * a change, and its delay after one. Sums of a quarter of a cluster are drawn directly, because
 * hundreds of years are simulated.
 *
 *   davar-track-clusters alarms KIND SHARE HOURS PER_HOUR [HOP [SEED]]
 *   davar-track-clusters delay KIND SHARE RATIO TRIALS PER_HOUR [HOP [SEED]]
 *
 * KIND: white flicker walk; 100 Hz, sigma 20 counts. White noise is added to KIND. At m = 4 HOP
 * samples the Allan deviation of KIND is SHARE times that of the white noise, and after half an
 * hour RATIO times as much. */
#include "detector/glr.h"

#include "random.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_HZ 100.0
#define SIGMA 20.0
#define MARKOV 14U       /* states of the flicker noise, correlated for 1, 2, 4 .. hops */
#define QUIET_S 1800.0   /* before a change */
#define PATIENCE_S 600.0 /* after it */

typedef enum { WHITE, FLICKER, WALK } kind_t;

typedef struct {
    random_t random;
    kind_t kind;
    double gain; /* of the kind, counts a hop */
    double state[MARKOV];
    double sum[8]; /* of the last hops */
    uint32_t at;
} source_t;

static uint32_t hop;
static uint64_t seed;

/* The new part is `gain` times as large; the old part remains. */
static double kind_next(source_t *source, double gain)
{
    if (source->kind == WHITE) {
        return 0.0;
    }
    if (source->kind == WALK) {
        source->state[0] =
            (source->state[0] * (1.0 - 1e-6)) + (gain * random_gauss(&source->random));
        return source->state[0];
    }
    double sum = 0.0;
    for (unsigned i = 0U; i < MARKOV; i++) {
        const double kept = exp(-1.0 / (double)(1U << i));
        source->state[i] = (source->state[i] * kept) +
                           (gain * sqrt(1.0 - (kept * kept)) * random_gauss(&source->random));
        sum += source->state[i];
    }
    return sum;
}

/* The next D, of the present hop. */
static double next(source_t *source, double white, double share)
{
    source->sum[source->at % 8U] = (white * sqrt(hop) * random_gauss(&source->random)) +
                                   kind_next(source, share * source->gain);
    double difference = 0.0;
    for (unsigned i = 0U; i < 4U; i++) {
        difference += source->sum[(source->at - i) % 8U] - source->sum[(source->at + 4U - i) % 8U];
    }
    source->at++;
    return difference;
}

/* White noise has D^2 = 2 m sigma^2 on average, and so has KIND. */
static source_t source_of(const char *kind)
{
    source_t source = {.random = random_seeded(seed), .kind = WHITE, .gain = 1.0};
    source.kind =
        (strcmp(kind, "walk") == 0) ? WALK : ((strcmp(kind, "flicker") == 0) ? FLICKER : WHITE);
    if (source.kind != WHITE) {
        double squares = 0.0;
        for (unsigned i = 0U; i < 400000U; i++) {
            const double difference = next(&source, 0.0, 1.0);
            squares += (i < 8U) ? 0.0 : (difference * difference);
        }
        source.gain = SIGMA * sqrt(8.0 * hop / (squares / 399992.0));
        memset(source.state, 0, sizeof source.state);
    }
    return source;
}

static void start(davar_glr_t *state, davar_glr_config_t *config, double per_hour)
{
    const davar_glr_wish_t wish = {
        .rate_hz = RATE_HZ, .false_alarms_per_hour = per_hour, .block = hop};
    davar_glr_start_clusters(config, &wish);
    davar_glr_reset(state);
}

static bool push(davar_glr_t *state, const davar_glr_config_t *config, double difference)
{
    davar_glr_event_t event;
    davar_glr_push_clusters_q15(state, config, (int32_t)lround(difference), &event);
    return event.is_alarm;
}

static void alarms(const char *kind, double share, double hours, double per_hour)
{
    static davar_glr_t state;
    davar_glr_config_t config;
    source_t source = source_of(kind);
    unsigned long count = 0U;
    start(&state, &config, per_hour);
    const uint64_t hops = (uint64_t)(hours * 3600.0 * RATE_HZ / hop);
    for (uint64_t i = 0U; i < hops; i++) {
        count += push(&state, &config, next(&source, SIGMA, share)) ? 1U : 0U;
    }
    printf("| %s %g | %u | %g | %g | %lu | %.4f |\n", kind, share, (unsigned)(4U * hop), per_hour,
           hours, count, (double)count / hours);
}

static int ascending(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

static double delay_of(source_t *source, double share, double ratio, double per_hour)
{
    static davar_glr_t state;
    davar_glr_config_t config;
    start(&state, &config, per_hour);
    const uint32_t quiet =
        (uint32_t)(QUIET_S * RATE_HZ / hop) + (uint32_t)(random_next(&source->random) % 512U);
    for (uint32_t i = 0U; i < quiet; i++) {
        (void)push(&state, &config, next(source, SIGMA, share));
    }
    const uint32_t patience = (uint32_t)(PATIENCE_S * RATE_HZ / hop);
    for (uint32_t i = 1U; i < patience; i++) {
        if (push(&state, &config, next(source, SIGMA, share * ratio))) {
            return i * hop / RATE_HZ;
        }
    }
    return PATIENCE_S;
}

static void delays(const char *kind, double share, double ratio, uint32_t trials, double per_hour)
{
    source_t source = source_of(kind);
    double *const delay = malloc(trials * sizeof *delay);
    if (delay == NULL) {
        exit(1);
    }
    uint32_t seen = 0U;
    for (uint32_t i = 0U; i < trials; i++) {
        delay[i] = delay_of(&source, share, ratio, per_hour);
        seen += (delay[i] < PATIENCE_S) ? 1U : 0U;
    }
    qsort(delay, trials, sizeof *delay, ascending);
    printf("| %s %g x%g | %u | %g | %u | %.0f %% | %.1f | %.1f |\n", kind, share, ratio,
           (unsigned)(4U * hop), per_hour, (unsigned)trials, 100.0 * seen / trials,
           delay[trials / 2U], delay[(trials * 9U) / 10U]);
    free(delay);
}

int main(int argc, char **argv)
{
    const bool is_delay = (argc > 1) && (strcmp(argv[1], "delay") == 0);
    const int last = is_delay ? 6 : 5; /* the last that must be there */
    if (argc <= last) {
        fputs("usage: davar-track-clusters alarms KIND SHARE HOURS PER_HOUR [HOP [SEED]] | delay "
              "KIND SHARE RATIO "
              "TRIALS PER_HOUR [HOP [SEED]]\n",
              stderr);
        return 2;
    }
    const double per_hour = strtod(argv[last], NULL);
    const double share = strtod(argv[3], NULL);
    hop = (argc > (last + 1)) ? (uint32_t)strtoul(argv[last + 1], NULL, 10) : 20U;
    seed = (argc > (last + 2)) ? strtoull(argv[last + 2], NULL, 10) : 1U;
    if (is_delay) {
        delays(argv[2], share, strtod(argv[4], NULL), (uint32_t)strtoul(argv[5], NULL, 10),
               per_hour);
    } else {
        alarms(argv[2], share, strtod(argv[4], NULL), per_hour);
    }
    return 0;
}
