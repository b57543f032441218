/* What Python asks of the library: Allan deviations of a recording in windows on a grid, filters as
 * --bandwidth has them, and the filter that a spectrum shows. Built with lib/'s own sources, so the
 * numbers are those of the device. And one loop that numpy has no function for: the likelihood of
 * levels in noise. */
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
double davar_lab_levels(const double *values, size_t count, const double given[3], unsigned levels,
                        double *chance);

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
#define TINY 1e-150       /* the least chance, and the least fit */
#define LOG_TINY (-345.0) /* its logarithm, or less */
#define SUM_LEAST 1e-100  /* of unscaled chances */

/* Half the distance of neighbouring levels, the noise of a value, and the chances to be on the same
 * level, or on a certain other one, at the next value. */
typedef struct {
    double amplitude;
    double noise;
    double stay;
    double other;
    unsigned levels;
} chain_t;

/* How well a value fits each level, over the level that it fits best; returns the logarithm of
 * that. */
static double fits_of(const chain_t *chain, double value, double fit[LEVELS_MOST])
{
    double most = -HUGE_VAL;
    for (unsigned l = 0U; l < chain->levels; l++) {
        const double place = (double)(chain->levels - 1U) - 2.0 * (double)l;
        const double off = (value - chain->amplitude * place) / chain->noise;
        fit[l] = -0.5 * off * off;
        most = (fit[l] > most) ? fit[l] : most;
    }
    for (unsigned l = 0U; l < chain->levels; l++) {
        const double under = fit[l] - most;
        fit[l] = (under > LOG_TINY) ? exp(under) : TINY;
    }
    return most;
}

/* Scales numbers to a sum of 1; returns the sum. */
static double scaled(double one[], unsigned count)
{
    double sum = 0.0;
    for (unsigned l = 0U; l < count; l++) {
        sum += one[l];
    }
    for (unsigned l = 0U; l < count; l++) {
        one[l] /= sum;
    }
    return sum;
}

/* The forward algorithm. Fills the chance of each level given the values up to each, up to a factor,
 * unless `chance` is null. Returns the log-likelihood. */
static double forward(const chain_t *chain, const double *values, size_t count, double *chance)
{
    double state[LEVELS_MOST];
    double fit[LEVELS_MOST];
    double total = -(double)count * log(chain->noise * 2.5066282746310002);
    double sum = 1.0;
    for (unsigned l = 0U; l < chain->levels; l++) {
        state[l] = 1.0 / (double)chain->levels;
    }
    for (size_t i = 0U; i < count; i++) {
        const double from_others = chain->other * sum;
        total += fits_of(chain, values[i], fit);
        sum = 0.0;
        for (unsigned l = 0U; l < chain->levels; l++) {
            state[l] = fit[l] * (from_others + (chain->stay - chain->other) * state[l]);
            sum += state[l];
        }
        if (sum < SUM_LEAST) {
            total += log(scaled(state, chain->levels));
            sum = 1.0;
        }
        if (chance != NULL) {
            memcpy(&chance[i * chain->levels], state, chain->levels * sizeof state[0]);
        }
    }
    return total + log(sum);
}

/* The backward algorithm: turns the chances given the values up to each into those given all. */
static void backward(const chain_t *chain, const double *values, size_t count, double *chance)
{
    double later[LEVELS_MOST];
    double fit[LEVELS_MOST];
    for (unsigned l = 0U; l < chain->levels; l++) {
        later[l] = 1.0;
    }
    for (size_t i = count; i > 0U; i--) {
        double *const here = &chance[(i - 1U) * chain->levels];
        (void)scaled(here, chain->levels);
        for (unsigned l = 0U; l < chain->levels; l++) {
            here[l] *= later[l];
        }
        (void)scaled(here, chain->levels);
        (void)fits_of(chain, values[i - 1U], fit);
        for (unsigned l = 0U; l < chain->levels; l++) {
            later[l] *= fit[l];
        }
        (void)scaled(later, chain->levels);
        for (unsigned l = 0U; l < chain->levels; l++) {
            later[l] = chain->other + (chain->stay - chain->other) * later[l];
        }
    }
}

/* A symmetric chain of levels in white noise; `given`: half the distance of neighbouring levels, the
 * noise of a value, and the chance to be on the same level at the next one. Returns the
 * log-likelihood of the values. chance: of each level, the highest first, at each value, row by
 * row; or null. */
double davar_lab_levels(const double *values, size_t count, const double given[3], unsigned levels,
                        double *chance)
{
    const double other = fmax((1.0 - given[2]) / (double)(levels - 1U), TINY);
    const chain_t chain = {given[0], given[1], given[2], other, levels};
    const double likelihood = forward(&chain, values, count, chance);
    if (chance != NULL) {
        backward(&chain, values, count, chance);
    }
    return likelihood;
}
