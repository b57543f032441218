/* davar tests - what a stream with a short window must report, summed again from its definition at
 * every question. Shares no code with lib/. Laws: fixed, kurtosis, or, and (4.1). */
#ifndef DAVAR_TESTS_SMALL_WINDOW_H
#define DAVAR_TESTS_SMALL_WINDOW_H

#include <math.h>
#include <string.h>

#define HISTORY 48 /* at least window.longest + stride */

/* Samples and boundaries by age: sample[0] is the newest, gap[a] is before the newest `a`. */
typedef struct {
    const davar_config_t *config;
    uint64_t total;    /* samples since the reset */
    int32_t count;     /* since the start or the restart */
    int32_t skip;      /* to drop until the window begins again */
    int32_t wait;      /* until the next epoch is complete */
    int32_t next;      /* length of the next window */
    int32_t length;    /* window of the newest epoch; 0 before the first */
    int32_t age;       /* samples since that epoch was complete */
    uint32_t restarts; /* since the reset */
    bool filling;
    bool reported; /* the newest epoch has a result */
    bool unstable;
    int16_t sample[HISTORY];
    bool gap[HISTORY];
} small_t;

typedef struct {
    double kurtosis;
    double contribution;
    bool outside[2]; /* kurtosis, contribution: of their bounds */
} small_moments_t;

static void small_begin(small_t *small)
{
    const davar_config_t *const config = small->config;
    const int32_t stride = (int32_t)config->stride;
    small->count = 0;
    small->wait = stride;
    small->next = stride;
    small->length = 0;
    small->age = 0;
    small->filling = true;
    small->reported = false;
    small->unstable = false;
    memset(small->sample, 0, sizeof small->sample);
    memset(small->gap, 0, sizeof small->gap);
}

static void small_start(small_t *small, const davar_config_t *config)
{
    memset(small, 0, sizeof *small);
    small->config = config;
    small_begin(small);
}

/* (4.2): the window of the newest epoch is [tail, tail + length), in samples since the start. */
static int32_t small_tail(const small_t *small)
{
    return small->count - small->age - small->length;
}

static int64_t small_sample(const small_t *small, int32_t position)
{
    return small->sample[small->count - 1 - position];
}

static bool small_gap(const small_t *small, int32_t position)
{
    return (position != 0) && small->gap[small->count - position];
}

/* (1.5): boundaries in (from, to), both excluded. */
static uint32_t small_gaps(const small_t *small, int32_t from, int32_t to)
{
    uint32_t count = 0U;
    for (int32_t at = from + 1; at < to; at++) {
        count += small_gap(small, at) ? 1U : 0U;
    }
    return count;
}

/* (1.1): the sum of D^2 over the window, and how many D. */
static int64_t small_sum(const small_t *small, int32_t m, uint32_t *differences)
{
    const int32_t tail = small_tail(small);
    int64_t sum = 0;
    *differences = 0U;
    for (int32_t i = tail; (i + (2 * m)) <= (tail + small->length); i++) {
        int64_t d = 0;
        for (int32_t j = i; j < (i + m); j++) {
            d += small_sample(small, j + m) - small_sample(small, j);
        }
        if (small_gaps(small, i, i + (2 * m)) == 0U) {
            sum += d * d;
            (*differences)++;
        }
    }
    return sum;
}

/* A kurtosis (3.1) as a quotient of integers; under 0: undefined. */
typedef struct {
    int64_t over;
    int64_t under;
} small_kurtosis_t;

/* Of the window without its newest `without` samples. */
static small_kurtosis_t small_kurtosis(const small_t *small, int32_t without)
{
    const int32_t tail = small_tail(small);
    const int64_t n = small->length - without;
    int64_t total = 0;
    int64_t second = 0;
    int64_t fourth = 0;
    for (int32_t i = 0; i < n; i++) {
        total += small_sample(small, tail + i);
    }
    for (int32_t i = 0; i < n; i++) {
        const int64_t d = (n * small_sample(small, tail + i)) - total;
        second += d * d;
        fourth += d * d * d * d;
    }
    const small_kurtosis_t kurtosis = {n * fourth, second * second};
    return kurtosis;
}

/* Rounded once. */
static double small_quotient(int64_t over, int64_t under)
{
    return (under == 0) ? (double)NAN : ((double)over / (double)under);
}

/* (3.1), (3.2) and the criteria of (3.4); what is undefined is inside. */
static small_moments_t small_moments(const small_t *small)
{
    const davar_config_t *const config = small->config;
    const small_kurtosis_t first = small_kurtosis(small, (int32_t)config->moments.segment);
    const small_kurtosis_t whole = small_kurtosis(small, 0);
    const int64_t of_whole = whole.over * first.under;
    const int64_t of_first = first.over * whole.under;
    const int64_t change = (of_whole > of_first) ? (of_whole - of_first) : (of_first - of_whole);
    const double k = small_quotient(whole.over, whole.under);
    const double s = small_quotient(change, of_whole);
    small_moments_t moments = {.kurtosis = k, .contribution = s};
    moments.outside[0] = (k < config->moments.kurtosis_low) || (k > config->moments.kurtosis_high);
    moments.outside[1] =
        (s < config->moments.contribution_low) || (s > config->moments.contribution_high);
    return moments;
}

static bool small_verdict(const small_t *small)
{
    const davar_law_t *const law = small->config->law;
    const small_moments_t moments = small_moments(small);
    if (law == &davar_law_kurtosis) {
        return moments.outside[0];
    }
    return (law == &davar_law_and) ? (moments.outside[0] && moments.outside[1])
                                   : (moments.outside[0] || moments.outside[1]);
}

/* (4.1) */
static void small_decide(small_t *small)
{
    const davar_config_t *const config = small->config;
    const int32_t stride = (int32_t)config->stride;
    const int32_t longest = (int32_t)config->window.longest;
    const int32_t shortest = (int32_t)config->window.shortest;
    const bool grows = small->filling || (config->law == NULL) || (config->window.grow > 0U);
    if ((config->law != NULL) && small->unstable) {
        const int32_t length = small->length - ((int32_t)config->window.shrink * stride);
        small->filling = false;
        small->next = (length > shortest) ? length : shortest;
        return;
    }
    if (small->filling && (small->length >= longest)) {
        small->filling = false;
    }
    const int32_t length = small->length + (grows ? stride : 0);
    small->next = (length < longest) ? length : longest;
}

static void small_epoch(small_t *small)
{
    small->length = small->next;
    small->age = 0;
    small->wait = (int32_t)small->config->stride;
    small->reported = (small->length >= (int32_t)small->config->window.shortest);
    small->unstable =
        small->reported && (small->config->moments.segment > 0U) && small_verdict(small);
    small_decide(small);
}

static void small_push(small_t *small, int16_t sample)
{
    small->total++;
    if (small->skip > 0) {
        small->skip--;
        return;
    }
    memmove(&small->sample[1], &small->sample[0], (HISTORY - 1) * sizeof small->sample[0]);
    memmove(&small->gap[1], &small->gap[0], (HISTORY - 1) * sizeof small->gap[0]);
    small->sample[0] = sample;
    small->gap[0] = false;
    small->count++;
    small->age++;
    small->wait--;
    if (small->wait == 0) {
        small_epoch(small);
    }
}

/* A boundary is stored while the window of the newest epoch, or a later one, can contain it. */
static void small_missing(small_t *small)
{
    if ((small->count == 0) || small->gap[0]) {
        return;
    }
    const int32_t tail = (small->length > 0) ? small_tail(small) : 0;
    const uint32_t stored = small_gaps(small, (tail > 0) ? tail : 0, small->count);
    if (stored < small->config->window.gaps_max) {
        small->gap[0] = true;
        return;
    }
    const int32_t stride = (int32_t)small->config->stride;
    small->skip = (stride - (int32_t)(small->total % (uint64_t)stride)) % stride;
    small->restarts++;
    small_begin(small);
}

/* Forgets what no later result depends on, so that equal futures are equal bytes. */
static void small_forget(small_t *small)
{
    const int32_t tail = (small->length > 0) ? small_tail(small) : 0;
    const int32_t kept = (tail > 0) ? (small->count - tail) : small->count;
    for (int32_t age = kept; age < HISTORY; age++) {
        small->sample[age] = 0;
        small->gap[age] = false;
    }
}

#endif
