/* davar-sim - instances. */
#include "instances/engine.h"
#include "davar/filter.h"

#include "davar_law_id.h"

#include <stdlib.h>

static size_t memory_size(davar_port_number_t number, const davar_config_t *config)
{
    switch (number) {
    case DAVAR_PORT_Q15:
        return davar_memory_size_q15(config);
    case DAVAR_PORT_Q31:
        return davar_memory_size_q31(config);
    case DAVAR_PORT_F32:
    default:
        return davar_memory_size_f32(config);
    }
}

static davar_status_t init(davar_port_number_t number, davar_t *davar, const davar_config_t *config,
                           void *memory, size_t bytes)
{
    switch (number) {
    case DAVAR_PORT_Q15:
        return davar_init_q15(davar, config, memory, bytes);
    case DAVAR_PORT_Q31:
        return davar_init_q31(davar, config, memory, bytes);
    case DAVAR_PORT_F32:
    default:
        return davar_init_f32(davar, config, memory, bytes);
    }
}

/* A window stores no more gaps than the recording has. Law glr treats shocks as gaps too. */
static void limit_gaps(davar_config_t *config, uint64_t gaps)
{
    const bool is_glr = (davar_law_id(config) == DAVAR_LAW_ID_GLR);
    if (!is_glr && (config->window.gaps_max > gaps)) {
        config->window.gaps_max = (uint16_t)gaps;
    }
}

static void configure(engine_t *engine, const settings_t *settings,
                      const quantisation_t *quantisation, const timing_t *timing)
{
    engine->config = settings->config;
    engine->config.rate_hz = timing->rate_hz;
    limit_gaps(&engine->config, timing->breaks);
    engine->config.unit_per_count = quantisation->unit_per_count;
    engine->config.full_scale = quantisation->full_scale;
    engine->config.sample_bits = quantisation->sample_bits;
    engine->number = quantisation->number;
    davar_retype(&engine->config, engine->number != DAVAR_PORT_Q15);
    if ((engine->number == DAVAR_PORT_Q15) &&
        (memory_size(DAVAR_PORT_Q15, &engine->config) == 0U)) {
        engine->number = DAVAR_PORT_Q31;
        davar_retype(&engine->config, true);
    }
}

/* Converts the filter of --bandwidth to the sample rate. Of learned filters, takes channel 0's. */
static bool declare(engine_t *engine, const learned_t *learned, const options_t *options,
                    sim_error_t *error)
{
    if (options->learns_filter) {
        engine->declared = learn_knows(&learned[0]) ? &learned[0].filter : NULL;
        return (options->device == NULL) || (engine->count == 1U) ||
               sim_fail(error, "--bandwidth auto: a device takes one filter for all columns; give "
                               "one --column, or the filter");
    }
    if (options->setup.filter[0] == '\0') {
        return true;
    }
    engine->declared = &engine->filter;
    return setup_filter(&options->setup, engine->config.rate_hz, &engine->filter, error);
}

static const davar_filter_t *filter_of(const engine_t *engine, const learned_t *learned,
                                       const options_t *options, size_t channel)
{
    if (!options->learns_filter) {
        return engine->declared;
    }
    return learn_knows(&learned[channel]) ? &learned[channel].filter : NULL;
}

static bool fail_memory(const engine_t *engine, sim_error_t *error)
{
    return sim_fail(error, "--window-max: out of memory for %u samples, %zu channels",
                    engine->config.window.longest, engine->count);
}

static bool allocate(engine_t *engine, size_t words, bool is_centred, sim_error_t *error)
{
    engine->instances = calloc(engine->count, sizeof *engine->instances);
    engine->cascades = calloc(engine->count, sizeof *engine->cascades);
    engine->channels = calloc(engine->count, sizeof *engine->channels);
    engine->memory = calloc(engine->count, words * sizeof *engine->memory);
    engine->filtered = calloc(engine->count, sizeof *engine->filtered);
    engine->filters = calloc(engine->count, sizeof(const davar_filter_t *));
    if (is_centred) {
        engine->centred = calloc(engine->count, sizeof(centred_t *));
    }
    if ((is_centred && (engine->centred == NULL)) || (engine->instances == NULL) ||
        (engine->cascades == NULL) || (engine->channels == NULL) || (engine->memory == NULL) ||
        (engine->filtered == NULL) || (engine->filters == NULL)) {
        return fail_memory(engine, error);
    }
    return true;
}

/* Starts the instance of one channel in its memory. Centred windows have their own; the library then
 * only checks the configuration, and for that it gets too little memory. */
static davar_status_t start_instance(engine_t *engine, size_t c, uint64_t *memory, size_t words)
{
    const davar_config_t *const config = &engine->filtered[c].config;
    const davar_status_t status =
        init(engine->number, &engine->instances[c], config, memory, words * sizeof *memory);
    return ((engine->centred != NULL) && (status == DAVAR_ERR_MEMORY_SIZE)) ? DAVAR_OK : status;
}

/* Starts one channel in its `words` of memory, of which the instance takes `own_words`. */
static bool start(engine_t *engine, size_t c, const davar_filter_t *filter, size_t words,
                  size_t own_words, const options_t *options, sim_error_t *error)
{
    filtered_t *const filtered = &engine->filtered[c];
    uint64_t *const memory = engine->memory + c * words;
    const bool has_cascade = (words > own_words);
    filtered->config = engine->config;
    setup_adapt(&options->setup, &filtered->config, filter);
    davar_curve_plan(&engine->curve, &filtered->plan, filter);
    engine->channels[c] =
        (davar_node_channel_t){.davar = &engine->instances[c],
                               .number = engine->number,
                               .cascade = has_cascade ? &engine->cascades[c] : NULL,
                               .plan = &filtered->plan};
    const davar_status_t status = start_instance(engine, c, memory, own_words);
    if (status != DAVAR_OK) {
        return setup_fail(status, options->arith == ARITH_FLOAT, error);
    }
    const davar_cascade_status_t cascade =
        has_cascade ? davar_curve_start(&engine->curve, engine->number, &engine->cascades[c],
                                        memory + own_words, (words - own_words) * sizeof *memory)
                    : DAVAR_CASCADE_OK;
    return (cascade == DAVAR_CASCADE_OK) ||
           sim_fail(error, "--longest-tau: %s", davar_cascade_status_text(cascade));
}

static bool open_centred(engine_t *engine, size_t c)
{
    engine->centred[c] = centred_open(&engine->filtered[c].config, engine->number);
    return engine->centred[c] != NULL;
}

bool engine_start(engine_t *engine, const settings_t *settings, const quantisation_t *quantisation,
                  const timing_t *timing, size_t count, const learned_t *learned,
                  const options_t *options, sim_error_t *error)
{
    *engine = (engine_t){.count = count};
    configure(engine, settings, quantisation, timing);
    if (!declare(engine, learned, options, error) ||
        !setup_curve(&options->setup, &engine->config, engine->number, &engine->curve, error)) {
        return false;
    }
    const bool is_centred = settings->is_centred;
    const size_t bytes = memory_size(engine->number, &engine->config);
    const size_t own_words = is_centred ? 1U : (bytes / sizeof *engine->memory + 1U);
    const size_t words =
        own_words + davar_curve_bytes(&engine->curve, engine->number) / sizeof *engine->memory;
    if (!allocate(engine, words, is_centred, error)) {
        return false;
    }
    for (size_t c = 0; c < count; c++) {
        const davar_filter_t *const filter = filter_of(engine, learned, options, c);
        engine->filters[c] = filter;
        if (!start(engine, c, filter, words, own_words, options, error)) {
            return false;
        }
        if (is_centred && !open_centred(engine, c)) {
            return fail_memory(engine, error);
        }
    }
    engine->config = engine->filtered[0].config;
    return true;
}

void engine_gap(const engine_t *engine, size_t c, uint32_t missing)
{
    davar_cascade_t *const cascade = engine->channels[c].cascade;
    if (engine->centred != NULL) {
        centred_gap(engine->centred[c], missing);
    } else {
        davar_gap(&engine->instances[c], missing);
    }
    if (cascade != NULL) {
        davar_cascade_gap(cascade, missing);
    }
}

void engine_add_health(davar_health_t *sum, const davar_health_t *one)
{
    sum->gaps = one->gaps;
    sum->missing = one->missing;
    sum->saturated += one->saturated;
    sum->not_finite += one->not_finite;
    sum->restarts += one->restarts;
    sum->missed += one->missed;
}

davar_health_t engine_health_of(const engine_t *engine, size_t channel)
{
    return (engine->centred != NULL) ? centred_health(engine->centred[channel])
                                     : davar_health(&engine->instances[channel]);
}

davar_health_t engine_health(const engine_t *engine)
{
    davar_health_t sum = {0};
    for (size_t c = 0; c < engine->count; c++) {
        const davar_health_t one = engine_health_of(engine, c);
        engine_add_health(&sum, &one);
    }
    return sum;
}

void engine_free(engine_t *engine)
{
    for (size_t c = 0; (c < engine->count) && (engine->centred != NULL); c++) {
        centred_close(engine->centred[c]);
    }
    free(engine->centred);
    free(engine->instances);
    free(engine->cascades);
    free(engine->channels);
    free(engine->filtered);
    free(engine->filters);
    free(engine->memory);
    *engine = (engine_t){0};
}
