/* davar-sim - batches: a sum for each run of `step` samples; the runs within a window are its
 * batches. */
#include "instances/batches.h"

#include "common/batch_limits.h"

#include <stdlib.h>
#include <string.h>

#define STEPS 64U        /* of the shortest window, at most */
#define STEPS_MOST 1024U /* of the longest one */

struct batches_channel {
    double *total; /* cumulative sums of samples, a ring */
    size_t mask;   /* its size - 1 */
    uint64_t samples;
    uint64_t since_gap; /* samples */
    double offset;      /* the first sample */
    batch_sums_t *now;  /* of the run that is not complete, one per size */
    batch_sums_t *runs; /* the complete ones, from number `first` on */
    uint64_t first;
    size_t count;
    size_t room;
};

static bool open_channel(batches_channel_t *channel, const davar_config_t *config)
{
    size_t size = 1U;
    while (size <= 2U * (size_t)config->taus[config->tau_count - 1U]) {
        size *= 2U;
    }
    channel->mask = size - 1U;
    channel->total = calloc(size, sizeof *channel->total);
    channel->now = calloc(config->tau_count, sizeof *channel->now);
    return (channel->total != NULL) && (channel->now != NULL);
}

bool batches_open(batches_t *batches, const options_t *options, const engine_t *engine,
                  sim_error_t *error)
{
    const davar_config_t *const config = &engine->config;
    if (!options->details || (davar_law_id(config) == DAVAR_LAW_ID_GLR)) {
        return true;
    }
    const uint32_t fine = config->window.shortest / STEPS;
    const uint32_t coarse = config->window.longest / STEPS_MOST;
    batches->step = (fine > coarse) ? fine : coarse;
    batches->step += (batches->step == 0U) ? 1U : 0U;
    batches->engine = engine;
    batches->channels = calloc(engine->count, sizeof *batches->channels);
    bool good = (batches->channels != NULL);
    for (size_t c = 0; good && (c < engine->count); c++) {
        good = open_channel(&batches->channels[c], config);
    }
    return good || sim_fail(error, "out of memory");
}

/* Keeps the sums of a complete run. */
static bool keep(batches_channel_t *channel, size_t taus)
{
    if (channel->count == channel->room) {
        const size_t room = 2U * channel->room + (size_t)4U * STEPS;
        batch_sums_t *const runs = realloc(channel->runs, room * taus * sizeof *runs);
        if (runs == NULL) {
            return false;
        }
        channel->runs = runs;
        channel->room = room;
    }
    memcpy(channel->runs + channel->count * taus, channel->now, taus * sizeof *channel->now);
    memset(channel->now, 0, taus * sizeof *channel->now);
    channel->count++;
    return true;
}

static bool push_sample(batches_channel_t *channel, const davar_config_t *config, uint32_t step,
                        double sample)
{
    channel->offset = (channel->samples == 0U) ? sample : channel->offset;
    const size_t at = channel->samples & channel->mask;
    channel->samples++;
    channel->since_gap++;
    const double newest = channel->total[at] + sample - channel->offset;
    channel->total[channel->samples & channel->mask] = newest;
    for (uint8_t t = 0;
         (t < config->tau_count) && (channel->since_gap >= 2U * (uint64_t)config->taus[t]); t++) {
        const uint64_t m = config->taus[t];
        const double middle = channel->total[(channel->samples - m) & channel->mask];
        const double oldest = channel->total[(channel->samples - 2U * m) & channel->mask];
        const double difference = newest - 2.0 * middle + oldest;
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
        return (double)samples->f32[i];
    }
}

bool batches_push(batches_t *batches, const davar_port_samples_t *samples, size_t count,
                  bool is_gap, sim_error_t *error)
{
    const engine_t *const engine = batches->engine;
    for (size_t c = 0; (engine != NULL) && (c < engine->count); c++) {
        batches_channel_t *const channel = &batches->channels[c];
        channel->since_gap = is_gap ? 0U : channel->since_gap;
        for (size_t i = 0; i < count; i++) {
            const double sample = sample_of(&samples[c], engine->number, i);
            if (!push_sample(channel, &engine->config, batches->step, sample)) {
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
} span_t;

static span_t span_of(const batches_t *batches, const batches_channel_t *channel,
                      const davar_result_t *result)
{
    const uint64_t length = result->window_samples;
    const uint64_t ahead = (batches->engine->centred != NULL) ? (length / 2U) : 1U;
    const uint64_t end = result->epoch + ahead;
    return (span_t){.begin = (end > length) ? (end - length) : 0U,
                    .end = (end < channel->samples) ? end : channel->samples};
}

/* Runs before this number are not needed again: no window begins earlier than the one before it. */
static void forget(batches_channel_t *channel, size_t taus, uint64_t needed)
{
    if (needed > channel->first + channel->count / 2U) {
        const uint64_t most = channel->first + channel->count;
        const size_t gone = (size_t)(((needed < most) ? needed : most) - channel->first);
        channel->count -= gone;
        memmove(channel->runs, channel->runs + gone * taus,
                channel->count * taus * sizeof *channel->runs);
        channel->first += gone;
    }
}

static void apply_size(const batches_t *batches, const batches_channel_t *channel, span_t span,
                       uint8_t t, davar_adev_t *tau)
{
    const size_t taus = batches->engine->config.tau_count;
    const uint64_t step = batches->step;
    /* Whole runs, by number. The differences of the window end after its first 2m samples. */
    const uint64_t begin = (span.begin + 2U * (uint64_t)tau->m + step - 1U) / step;
    const uint64_t newest = channel->first + channel->count;
    const uint64_t end = (span.end / step < newest) ? (span.end / step) : newest;
    if ((end > begin) && (begin >= channel->first)) {
        batch_limits(&channel->runs[(begin - channel->first) * taus + t], taus, end - begin, step,
                     (double)(span.end - span.begin) / (double)tau->m, tau);
    }
}

void batches_apply(batches_t *batches, size_t channel, davar_result_t *result)
{
    if (batches->engine == NULL) {
        return;
    }
    const uint8_t taus = batches->engine->config.tau_count;
    batches_channel_t *const of = &batches->channels[channel];
    const span_t span = span_of(batches, of, result);
    const bool applies = batch_limits_apply(result);
    for (uint8_t t = 0; applies && (t < taus); t++) {
        if (result->tau[t].differences > 0U) {
            apply_size(batches, of, span, t, &result->tau[t]);
        }
    }
    forget(of, taus, span.begin / batches->step);
}

void batches_close(batches_t *batches)
{
    for (size_t c = 0; (batches->channels != NULL) && (c < batches->engine->count); c++) {
        free(batches->channels[c].total);
        free(batches->channels[c].now);
        free(batches->channels[c].runs);
    }
    free(batches->channels);
    *batches = (batches_t){0};
}
