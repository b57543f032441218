/* davar-sim - batches. Sums of squared differences are kept at every `step` samples; a window of
 * any length is cut there. */
#include "instances/batches.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BATCHES ((uint64_t)8U)
#define BATCHES_STEPS 64U /* of the shortest window: a batch is a few of them */
#define NORMAL_95 1.96
#define STUDENT_95 2.365 /* of a variance from eight batches */
#define CUBE_LEAST 1e-4
#define EDF_LEAST 0.8

/* Relative variance of the mean of batches, with the covariance of neighbours. */
static double relative_variance(const double mean_of[BATCHES], double mean)
{
    double own = 0.0;
    double next = 0.0;
    for (uint32_t b = 0; b < BATCHES; b++) {
        const double off = mean_of[b] / mean - 1.0;
        own += off * off;
        next += (b > 0U) ? (off * (mean_of[b - 1U] / mean - 1.0)) : 0.0;
    }
    return (own + ((next > 0.0) ? (2.0 * next) : 0.0)) / ((BATCHES - 1.0) * BATCHES);
}

/* Wilson and Hilferty. */
static double limit_of(double variance, double part, double sigmas)
{
    const double third = 1.0 - part + sigmas * sqrt(part);
    return sqrt(variance / fmax(third * third * third, CUBE_LEAST));
}

void batches_limits(const batch_sums_t *sums, size_t stride, uint64_t steps, uint64_t step,
                    double clusters, davar_adev_t *tau)
{
    double mean_of[BATCHES];
    double mean = 0.0;
    if ((steps < 2U * BATCHES) || (steps * step < BATCHES * tau->m)) {
        return;
    }
    for (uint32_t b = 0; b < BATCHES; b++) {
        const batch_sums_t *const first = &sums[b * steps / BATCHES * stride];
        const batch_sums_t *const last = &sums[(b + 1U) * steps / BATCHES * stride];
        if (!(last->count > first->count)) {
            return;
        }
        mean_of[b] = (last->squares - first->squares) / (last->count - first->count);
        mean += mean_of[b] / BATCHES;
    }
    if (!(mean > 0.0)) {
        return;
    }
    const double variance = fmax(relative_variance(mean_of, mean), 1.0 / clusters);
    const double few = STUDENT_95 / NORMAL_95;
    const double edf = fmax(2.0 / (variance * few * few), EDF_LEAST);
    const double part = 2.0 / (9.0 * edf);
    tau->edf = edf;
    tau->low = limit_of(tau->adev * tau->adev, part, NORMAL_95);
    tau->high = limit_of(tau->adev * tau->adev, part, -NORMAL_95);
}

/* --- samples in --- */

struct batches_channel {
    double *total; /* cumulative sums of samples, a ring */
    size_t mask;   /* its size - 1 */
    uint64_t samples;
    uint64_t run;       /* samples since the last gap */
    double offset;      /* the first sample */
    batch_sums_t *now;  /* one per size */
    batch_sums_t *kept; /* ... after each `step` samples, from number `first` on */
    uint64_t first;
    size_t count;
    size_t room;
};

static uint32_t step_of(const engine_t *engine)
{
    const uint32_t step = engine->config.window.shortest / BATCHES_STEPS;
    return (step > 0U) ? step : 1U;
}

/* Keeps the sums of this step. */
static bool keep(batches_channel_t *channel, size_t taus)
{
    if (channel->count == channel->room) {
        const size_t room = 2U * channel->room + (size_t)4U * BATCHES_STEPS;
        batch_sums_t *const kept = realloc(channel->kept, room * taus * sizeof *kept);
        if (kept == NULL) {
            return false;
        }
        channel->kept = kept;
        channel->room = room;
    }
    memcpy(channel->kept + channel->count * taus, channel->now, taus * sizeof *channel->now);
    channel->count++;
    return true;
}

static bool open_channel(batches_channel_t *channel, const davar_config_t *config)
{
    size_t size = 1U;
    while (size <= 2U * (size_t)config->taus[config->tau_count - 1U]) {
        size *= 2U;
    }
    channel->mask = size - 1U;
    channel->total = calloc(size, sizeof *channel->total);
    channel->now = calloc(config->tau_count, sizeof *channel->now);
    return (channel->total != NULL) && (channel->now != NULL) && keep(channel, config->tau_count);
}

bool batches_open(batches_t *batches, const options_t *options, const engine_t *engine,
                  sim_error_t *error)
{
    if (!options->details) {
        return true;
    }
    batches->engine = engine;
    batches->is_centred = (engine->centred != NULL);
    batches->channels = calloc(engine->count, sizeof *batches->channels);
    bool good = (batches->channels != NULL);
    for (size_t c = 0; good && (c < engine->count); c++) {
        good = open_channel(&batches->channels[c], &engine->config);
    }
    return good || sim_fail(error, "out of memory");
}

static bool push_sample(batches_channel_t *channel, const davar_config_t *config, uint32_t step,
                        double sample)
{
    channel->offset = (channel->samples == 0U) ? sample : channel->offset;
    const size_t at = channel->samples & channel->mask;
    channel->samples++;
    channel->run++;
    const double newest = channel->total[at] + sample - channel->offset;
    channel->total[channel->samples & channel->mask] = newest;
    for (uint8_t t = 0; (t < config->tau_count) && (channel->run >= 2U * (uint64_t)config->taus[t]);
         t++) {
        const uint64_t m = config->taus[t];
        const double difference = newest -
                                  2.0 * channel->total[(channel->samples - m) & channel->mask] +
                                  channel->total[(channel->samples - 2U * m) & channel->mask];
        channel->now[t].squares += difference * difference;
        channel->now[t].count += 1.0;
    }
    return (channel->samples % step != 0U) || keep(channel, config->tau_count);
}

static double sample_of(const davar_port_samples_t *samples, davar_port_number_t number, size_t i)
{
    switch (number) {
    case DAVAR_PORT_Q15:
        return samples->q15[i];
    case DAVAR_PORT_Q31:
        return samples->q31[i];
    case DAVAR_PORT_F32:
    default:
        return isfinite(samples->f32[i]) ? (double)samples->f32[i] : 0.0;
    }
}

bool batches_push(batches_t *batches, const davar_port_samples_t *samples, size_t count,
                  bool is_gap, sim_error_t *error)
{
    const engine_t *const engine = batches->engine;
    for (size_t c = 0; (engine != NULL) && (c < engine->count); c++) {
        batches_channel_t *const channel = &batches->channels[c];
        channel->run = is_gap ? 0U : channel->run;
        for (size_t i = 0; i < count; i++) {
            const double sample = sample_of(&samples[c], engine->number, i);
            if (!push_sample(channel, &engine->config, step_of(engine), sample)) {
                return sim_fail(error, "out of memory");
            }
        }
    }
    return true;
}

/* --- a result --------------------------------------------------------------------------------- */

/* The samples of the window that are there: from `begin` to before `end`. */
typedef struct {
    uint64_t begin;
    uint64_t end;
} part_t;

static part_t part_of(const batches_t *batches, const batches_channel_t *channel,
                      const davar_result_t *result)
{
    const uint64_t length = result->window_samples;
    const uint64_t ahead = batches->is_centred ? (length / 2U) : 1U;
    const uint64_t end = result->epoch + ahead;
    return (part_t){.begin = (end > length) ? (end - length) : 0U,
                    .end = (end < channel->samples) ? end : channel->samples};
}

/* Steps before this place are not needed again. */
static void forget(batches_channel_t *channel, size_t taus, uint64_t step, uint64_t begin)
{
    const uint64_t needed = begin / step;
    if (needed > channel->first + channel->count / 2U) {
        const size_t gone = (size_t)(needed - channel->first);
        channel->count -= gone;
        memmove(channel->kept, channel->kept + gone * taus,
                channel->count * taus * sizeof *channel->kept);
        channel->first = needed;
    }
}

static void apply_size(const batches_channel_t *channel, const davar_config_t *config,
                       uint64_t step, part_t part, uint8_t t, davar_adev_t *tau)
{
    /* Whole steps, by number. The differences of the window end after its first 2m samples. */
    const uint64_t begin = (part.begin + 2U * (uint64_t)tau->m + step - 1U) / step;
    const uint64_t newest = channel->first + channel->count - 1U;
    const uint64_t end = (part.end / step < newest) ? (part.end / step) : newest;
    if ((end > begin) && (begin >= channel->first)) {
        const size_t at = (size_t)(begin - channel->first);
        batches_limits(&channel->kept[at * config->tau_count + t], config->tau_count, end - begin,
                       step, (double)(part.end - part.begin) / (double)tau->m, tau);
    }
}

void batches_apply(batches_t *batches, size_t channel, davar_result_t *result)
{
    if (batches->engine == NULL) {
        return;
    }
    const davar_config_t *const config = &batches->engine->config;
    const uint64_t step = step_of(batches->engine);
    batches_channel_t *const of = &batches->channels[channel];
    const part_t part = part_of(batches, of, result);
    const bool is_white = (result->noise == DAVAR_NOISE_WHITE) && (result->flat_from == 0U);
    for (uint8_t t = 0; !is_white && (t < config->tau_count); t++) {
        if (result->tau[t].differences > 0U) {
            apply_size(of, config, step, part, t, &result->tau[t]);
        }
    }
    const uint64_t longest = config->window.longest;
    forget(of, config->tau_count, step, (part.begin > longest) ? (part.begin - longest) : 0U);
}

void batches_close(batches_t *batches)
{
    for (size_t c = 0; (batches->channels != NULL) && (c < batches->engine->count); c++) {
        free(batches->channels[c].total);
        free(batches->channels[c].now);
        free(batches->channels[c].kept);
    }
    free(batches->channels);
    *batches = (batches_t){0};
}
