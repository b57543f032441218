/* What Python asks of the library: Allan deviations of a recording in windows on a grid, filters as
 * --bandwidth has them, and the filter that a spectrum shows. Built with lib/'s own sources, so the
 * numbers are those of the device. And one loop that numpy has no function for: the likelihood of
 * levels beside noise. A function whose arguments change gets another name: Python then refuses an
 * older library, which would read and write through the wrong pointers. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "learning/learn.h"
#include "setup/bandwidth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int davar_lab_windows(const float *rates, size_t count, double full_scale, uint32_t window,
                      uint32_t stride, const uint32_t *taus, uint8_t tau_count, double *adev,
                      size_t rows);
double davar_lab_edf(int noise, uint32_t m, uint32_t window);
const char *davar_lab_filter(const char *text, double rate_hz, davar_filter_t *filter);
int davar_lab_learn(const double bins[][4], size_t count, double rounding, int is_steady,
                    char *text);
double davar_lab_chain(const double *values, size_t count, const double slow[][2],
                       unsigned processes, const double given[3], unsigned levels, double *chance);

static size_t take_full(davar_t *davar, uint32_t window, double *adev, size_t row, size_t rows)
{
    davar_result_t result;
    if (!davar_take(davar, &result) || result.window_samples < window || row == rows) {
        return row;
    }
    for (uint8_t t = 0; t < result.tau_count; t++) {
        adev[(row * result.tau_count) + t] = result.tau[t].adev;
    }
    return row + 1;
}

static size_t run(davar_t *davar, const float *rates, size_t count, uint32_t window, double *adev,
                  size_t rows)
{
    size_t row = 0;
    for (size_t done = 0; done < count;) {
        done += davar_push_until_result_f32(davar, rates + done, count - done);
        row = take_full(davar, window, adev, row, rows);
    }
    return row;
}

/* Allan deviations (unit of the rates) of the full windows that end at samples k stride - 1, row by
 * row. Returns the rows written, or -(1 + status) when the library refuses, -100 when memory is
 * short. */
int davar_lab_windows(const float *rates, size_t count, double full_scale, uint32_t window,
                      uint32_t stride, const uint32_t *taus, uint8_t tau_count, double *adev,
                      size_t rows)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 1.0;
    config.full_scale = full_scale;
    config.taus = taus;
    config.tau_count = tau_count;
    config.law = NULL;
    config.window.longest = config.window.shortest = window;
    config.moments.segment = 0;
    config.stride = stride;
    const size_t bytes = davar_memory_size_f32(&config);
    void *memory = malloc(bytes > 0 ? bytes : 8);
    if (memory == NULL) {
        return -100;
    }
    davar_t davar;
    const davar_status_t status = davar_init_f32(&davar, &config, memory, bytes);
    const int done =
        status == DAVAR_OK ? (int)run(&davar, rates, count, window, adev, rows) : -1 - (int)status;
    free(memory);
    return done;
}

double davar_lab_edf(int noise, uint32_t m, uint32_t window)
{
    return davar_edf((davar_coefficient_kind_t)noise, m, window);
}

/* Reads a value of --bandwidth. Returns null, or what was expected. */
const char *davar_lab_filter(const char *text, double rate_hz, davar_filter_t *filter)
{
    *filter = (davar_filter_t){.b = {0.0}};
    return bandwidth_read(text, rate_hz, filter);
}

/* The filter that a spectrum shows, as a value of --bandwidth of LEARN_TEXT bytes; "": none. Rows
 * of bins: angle, power, independent ordinates that vary as exponentials, and the power without the
 * filter up to a factor; is_steady: that has the flicker and the walk. rounding: power after the
 * filter. Returns the numbers that it has. */
int davar_lab_learn(const double bins[][4], size_t count, double rounding, int is_steady,
                    char *text)
{
    static const unsigned of_averages = 2U;
    arma_data_t *const data = calloc(1U, sizeof *data);
    learn_choice_t choice;
    text[0] = '\0';
    if ((data == NULL) || (count > ARMA_BINS_MOST)) {
        free(data);
        return 0;
    }
    data->rounding = rounding;
    data->is_steady = (is_steady != 0);
    for (data->count = 0U; data->count < count; data->count++) {
        const double *const row = bins[data->count];
        data->bin[data->count] =
            (arma_bin_t){.angle = row[0], .power = row[1], .weight = row[2], .known = row[3]};
    }
    arma_turn(data);
    learn_choose(data, &choice);
    free(data);
    const learned_t learned = {.status = LEARN_FOUND,
                               .filter = choice.filter,
                               .averages = choice.averages,
                               .length = choice.length};
    if ((choice.averages > 0U) || (choice.model.order > 0U)) {
        learn_option(&learned, text);
    }
    return (int)((choice.averages > 0U) ? of_averages : (2U * choice.model.order));
}

#define LEVELS_MOST 8U
#define SLOW_MOST 20U
#define PATHS_MOST 128U    /* followed at once; a switch that is in doubt for longer loses some */
#define CHANCE_LEAST 1e-12 /* of a path that is followed */

/* The noise of the values: processes of first order, rows of decay and variance, in white noise.
 * Levels are a known course for each path, so all paths share the gain of one Kalman filter. */
typedef struct {
    const double (*slow)[2];
    unsigned processes;
    double white;
    double covariance[SLOW_MOST][SLOW_MOST];
    double gain[SLOW_MOST];
    double spread;
} noise_t;

/* All courses of the levels that have switched last at one value, from one level to another. `slow`:
 * the mean of the processes at the next value; before: its place at the value before, or
 * -1 - level: it has come from this level. */
typedef struct {
    double slow[SLOW_MOST];
    double chance;
    unsigned level;
    int before;
} path_t;

/* What is kept of a path for the way back. */
typedef struct {
    double chance;
    uint8_t level;
    int16_t before;
} trace_t;

typedef struct {
    noise_t noise;
    double amplitude; /* half the distance of neighbouring levels */
    double leave;     /* chance of a switch between two values */
    unsigned levels;
    unsigned count;
    path_t path[PATHS_MOST];
    trace_t *trace; /* of all values, or null */
    size_t *first;  /* place in it of the paths at each value, and of its end */
} chain_t;

static void next_covariance(noise_t *noise)
{
    double sum[SLOW_MOST];
    noise->spread = noise->white;
    for (unsigned i = 0U; i < noise->processes; i++) {
        sum[i] = 0.0;
        for (unsigned j = 0U; j < noise->processes; j++) {
            sum[i] += noise->covariance[i][j];
        }
        noise->spread += sum[i];
    }
    for (unsigned i = 0U; i < noise->processes; i++) {
        const double *const one = noise->slow[i];
        noise->gain[i] = sum[i] / noise->spread;
        for (unsigned j = 0U; j <= i; j++) {
            const double left = noise->covariance[i][j] - (noise->gain[i] * sum[j]);
            noise->covariance[i][j] = left * one[0] * noise->slow[j][0];
            noise->covariance[j][i] = noise->covariance[i][j];
        }
        noise->covariance[i][i] += one[1] * (1.0 - (one[0] * one[0]));
    }
}

/* Moves a path on by a value; returns its log-likelihood up to what all paths share. */
static double follow(path_t *path, const chain_t *chain, double value)
{
    const noise_t *const noise = &chain->noise;
    double off =
        value - (chain->amplitude * ((double)(chain->levels - 1U) - (2.0 * (double)path->level)));
    for (unsigned i = 0U; i < noise->processes; i++) {
        off -= path->slow[i];
    }
    for (unsigned i = 0U; i < noise->processes; i++) {
        path->slow[i] = (path->slow[i] + (noise->gain[i] * off)) * noise->slow[i][0];
    }
    return -0.5 * off * off / noise->spread;
}

/* All paths beside a value, their chances given it and all before; returns its log-likelihood. */
static double weigh(chain_t *chain, double value)
{
    double fit[PATHS_MOST];
    double most = -HUGE_VAL;
    double sum = 0.0;
    for (unsigned k = 0U; k < chain->count; k++) {
        fit[k] = follow(&chain->path[k], chain, value);
        most = (fit[k] > most) ? fit[k] : most;
    }
    for (unsigned k = 0U; k < chain->count; k++) {
        chain->path[k].chance *= exp(fit[k] - most);
        sum += chain->path[k].chance;
    }
    for (unsigned k = 0U; k < chain->count; k++) {
        chain->path[k].chance /= sum;
    }
    // cppcheck-suppress invalidFunctionArg ; there is a path
    return most + log(sum) - (0.5 * log(6.283185307179586 * chain->noise.spread));
}

/* The path that begins with a switch from a level, to any one of the others: the mean of all paths
 * on it. */
static path_t switched(const chain_t *chain, unsigned from)
{
    path_t fresh = {.before = -1 - (int)from};
    for (unsigned k = 0U; k < chain->count; k++) {
        const path_t *const path = &chain->path[k];
        if (path->level == from) {
            fresh.chance += path->chance;
            for (unsigned i = 0U; i < chain->noise.processes; i++) {
                fresh.slow[i] += path->chance * path->slow[i];
            }
        }
    }
    for (unsigned i = 0U; (i < chain->noise.processes) && (fresh.chance > 0.0); i++) {
        fresh.slow[i] /= fresh.chance;
    }
    fresh.chance *= chain->leave / (double)(chain->levels - 1U);
    return fresh;
}

static unsigned likelier_than(const chain_t *chain, double least)
{
    unsigned found = 0U;
    for (unsigned k = 0U; k < chain->count; k++) {
        found += (chain->path[k].chance > least) ? 1U : 0U;
    }
    return found;
}

/* How likely a path is at least, so that there is room for the new ones. */
static double least_chance(const chain_t *chain)
{
    const unsigned room = PATHS_MOST - (chain->levels * (chain->levels - 1U));
    double least = CHANCE_LEAST;
    while (likelier_than(chain, least) > room) {
        least *= 2.0;
    }
    return least;
}

/* Paths that stay on their level until the next value, and those that switch. */
static void branch(chain_t *chain)
{
    path_t fresh[LEVELS_MOST * LEVELS_MOST];
    const double least = least_chance(chain);
    unsigned begun = 0U;
    unsigned kept = 0U;
    for (unsigned from = 0U; from < chain->levels; from++) {
        const path_t left = switched(chain, from);
        for (unsigned to = 0U; to < chain->levels; to++) {
            fresh[begun] = left;
            fresh[begun].level = to;
            begun += ((from != to) && (left.chance > 0.0)) ? 1U : 0U;
        }
    }
    for (unsigned k = 0U; k < chain->count; k++) {
        if (chain->path[k].chance > least) {
            chain->path[kept] = chain->path[k];
            chain->path[kept].before = (int)k;
            chain->path[kept].chance *= 1.0 - chain->leave;
            kept++;
        }
    }
    // cppcheck-suppress uninitvar ; switched() made so many
    memcpy(&chain->path[kept], fresh, begun * sizeof fresh[0]);
    chain->count = kept + begun;
}

static void keep_trace(chain_t *chain, size_t place)
{
    size_t end = chain->first[place];
    for (unsigned k = 0U; k < chain->count; k++) {
        const path_t *const path = &chain->path[k];
        chain->trace[end++] = (trace_t){path->chance, (uint8_t)path->level, (int16_t)path->before};
    }
    chain->first[place + 1U] = end;
}

static double forward(chain_t *chain, const double *values, size_t count)
{
    double total = 0.0;
    for (size_t i = 0U; i < count; i++) {
        next_covariance(&chain->noise);
        total += weigh(chain, values[i]);
        if (chain->trace != NULL) {
            keep_trace(chain, i);
        }
        if (chain->levels > 1U) {
            branch(chain);
        }
    }
    return total;
}

/* From the chances of the paths at a value, given all values, those at the value before: of those
 * that stayed, and of those from which the others have come. */
static void step_back(const chain_t *chain, size_t place, const double now[PATHS_MOST],
                      double before[PATHS_MOST])
{
    const trace_t *const here = &chain->trace[chain->first[place]];
    const trace_t *const there = &chain->trace[chain->first[place - 1U]];
    double left[LEVELS_MOST] = {0.0};
    double all[LEVELS_MOST] = {0.0};
    memset(before, 0, PATHS_MOST * sizeof before[0]);
    for (size_t k = 0U; k < (chain->first[place + 1U] - chain->first[place]); k++) {
        if (here[k].before >= 0) {
            before[here[k].before] += now[k];
        } else {
            left[-1 - here[k].before] += now[k];
        }
    }
    const size_t many = chain->first[place] - chain->first[place - 1U];
    for (size_t k = 0U; k < many; k++) {
        all[there[k].level] += there[k].chance;
    }
    for (size_t k = 0U; k < many; k++) {
        const unsigned level = there[k].level;
        before[k] += (all[level] > 0.0) ? left[level] * there[k].chance / all[level] : 0.0;
    }
}

/* The chance of each level at each value, given all values. */
static void backward(const chain_t *chain, size_t count, double *chance)
{
    double now[PATHS_MOST];
    double before[PATHS_MOST];
    const trace_t *const last = &chain->trace[chain->first[count - 1U]];
    for (unsigned k = 0U; k < PATHS_MOST; k++) {
        const int there = k < (chain->first[count] - chain->first[count - 1U]);
        now[k] = there ? last[k].chance : 0.0;
    }
    memset(chance, 0, count * chain->levels * sizeof chance[0]);
    for (size_t i = count; i > 0U; i--) {
        const size_t first = chain->first[i - 1U];
        for (size_t k = first; k < chain->first[i]; k++) {
            chance[((i - 1U) * chain->levels) + chain->trace[k].level] += now[k - first];
        }
        if (i > 1U) {
            step_back(chain, i - 1U, now, before);
            memcpy(now, before, sizeof now);
        }
    }
}

/* A symmetric chain of levels beside slow and white noise. slow: decay and variance of processes of
 * first order; given: the variance of the white noise, half the distance of neighbouring levels, and
 * the chance of a switch between two values. Returns the log-likelihood of the values. chance: of
 * each level, the highest first, at each value, row by row; or null. One level: the noise alone.
 * -HUGE_VAL when memory is short, or there are no values or too many processes or levels. */
double davar_lab_chain(const double *values, size_t count, const double slow[][2],
                       unsigned processes, const double given[3], unsigned levels, double *chance)
{
    if ((count == 0U) || (processes > SLOW_MOST) || (levels == 0U) || (levels > LEVELS_MOST)) {
        return -HUGE_VAL;
    }
    double found = -HUGE_VAL;
    const size_t traces = (chance != NULL) ? count : 0U;
    chain_t *const chain = calloc(1U, sizeof *chain);
    trace_t *const trace = malloc((traces + 1U) * PATHS_MOST * sizeof *trace);
    size_t *const first = calloc(traces + 1U, sizeof *first);
    if ((chain != NULL) && (trace != NULL) && (first != NULL)) {
        chain->noise = (noise_t){.slow = slow, .processes = processes, .white = given[0]};
        chain->amplitude = given[1];
        chain->leave = given[2];
        chain->levels = chain->count = levels;
        chain->first = first;
        chain->trace = (chance != NULL) ? trace : NULL;
        for (unsigned i = 0U; i < processes; i++) {
            chain->noise.covariance[i][i] = slow[i][1];
        }
        for (unsigned l = 0U; l < levels; l++) {
            chain->path[l] = (path_t){.chance = 1.0 / (double)levels, .level = l, .before = -1};
        }
        found = forward(chain, values, count);
        if (chance != NULL) {
            backward(chain, count, chance);
        }
    }
    free(first);
    free(trace);
    free(chain);
    return found;
}
