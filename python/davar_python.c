/* davar for Python - settings, counts, instance and columns as in davar-sim's simulate.c; samples
 * and rows are arrays. */
#include "davar_python.h"

#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/monitor.h"
#include "davar/torn.h"
#include "instances/batches.h"
#include "instances/engine.h"
#include "instances/floors.h"
#include "instances/settings.h"
#include "options/options.h"
#include "output/fields.h"
#include "recording/quantise.h"
#include "slide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHUNK 4096U
#define MODEL_MAX 64U /* cluster sizes of an error model */
#define PLANS 256U

/* Large and points into itself: allocated once, never moved. */
struct davar_python {
    options_t options;
    settings_t settings;
    quantisation_t quantisation;
    learned_t learned;
    engine_t engine;
    fields_t fields;
    floors_t floors;
    batches_t batches;
    bool is_gap; /* before the next sample of these two */
    davar_result_t result;
    davar_glr_report_t report;
    davar_model_tau_t model[MODEL_MAX];
    davar_monitor_t monitor;
    davar_misfit_t misfit;
    size_t model_count; /* 0: no error model */
    uint32_t fit_every; /* epochs; 0: none */
    uint32_t unfitted;  /* epochs before the next fit */
    /* Copies of the plan. A window has the one at its length % PLANS, so that the plan need not
     * follow the window when its length changes. */
    davar_plan_t *plans;
    extent_t extent; /* of all admitted values */
    slide_t slide;
    size_t slid;              /* rows that it has written */
    double alike[FIELDS_MAX]; /* the cells of a row of a full window without a fit */
    bool has_alike;
    sim_error_t error;
    union {
        int16_t q15[CHUNK];
        int32_t q31[CHUNK];
        float f32[CHUNK];
    } samples;
};

davar_python_t *davar_python_new(void)
{
    davar_python_t *run = calloc(1U, sizeof *run);
    if (run != NULL) {
        run->options = options_usual;
        run->fit_every = 1U;
    }
    return run;
}

void davar_python_free(davar_python_t *run)
{
    if (run != NULL) {
        floors_close(&run->floors);
        batches_close(&run->batches);
        engine_free(&run->engine);
        slide_close(&run->slide);
        free(run->plans);
        free(run);
    }
}

const char *davar_python_error(const davar_python_t *run)
{
    return run->error.text;
}

bool davar_python_option(davar_python_t *run, const char *name, const char *text)
{
    static const option_t FIT_EVERY = {.name = "fit-every"};
    if (strcmp(name, FIT_EVERY.name) == 0) {
        return read_whole(&FIT_EVERY, text, &run->fit_every, &run->error);
    }
    return command_set(&options_command, &run->options, name, text, &run->error);
}

bool davar_python_configure(davar_python_t *run, uint64_t *needed)
{
    if (!settings_make(&run->settings, &run->options, &run->error)) {
        return false;
    }
    *needed = settings_samples_needed(&run->settings);
    return true;
}

bool davar_python_admit(davar_python_t *run, bool counted, double *values, size_t count,
                        size_t *bad)
{
    const unit_t unit = counted ? UNIT_COUNTS : UNIT_DPS;
    for (size_t i = 0; i < count; i++) {
        const char *problem = quantise_admit(&run->options, unit, values[i], &values[i]);
        if (problem != NULL) {
            *bad = i;
            return sim_fail(&run->error, "%s", problem);
        }
    }
    return true;
}

size_t davar_python_torn(const double *counts, size_t count, const size_t *ends, bool *torn)
{
    davar_torn_t filter;
    int32_t before = 0;
    size_t end = 0;
    davar_torn_init(&filter);
    for (size_t i = 0; i < count; i++) {
        torn[i] = false;
        if (i == ends[end]) {
            (void)davar_torn_gap(&filter, &before);
            end++;
        }
        if (davar_torn_push(&filter, (int32_t)counts[i], &before) == DAVAR_TORN_READ) {
            torn[i - 1U] = true;
        }
    }
    return davar_torn_reads(&filter);
}

bool davar_python_model(davar_python_t *run, const uint32_t *m, const double *adev_dps,
                        const double *tolerance, size_t count)
{
    for (size_t i = 0; (i < count) && (i < MODEL_MAX); i++) {
        run->model[i] = (davar_model_tau_t){m[i], adev_dps[i], tolerance[i]};
    }
    if ((count > MODEL_MAX) || (davar_monitor_init(&run->monitor, run->model, (uint8_t)count,
                                                   DAVAR_MONITOR_MEMORY) != DAVAR_MONITOR_OK)) {
        return sim_fail(
            &run->error,
            "--model-table: 1 to %u cluster sizes expected, each once, with deviations above 0 and "
            "tolerances not below 0",
            MODEL_MAX);
    }
    run->model_count = count;
    return true;
}

/* True if there is no error model, or it has a cluster size of the results and each is fitted. */
static bool model_fits(davar_python_t *run)
{
    if ((run->model_count > 0U) && (run->fit_every != 1U)) {
        return sim_fail(&run->error,
                        "--fit-every: must be 1 with --model-table, which compares every result");
    }
    const davar_curve_t *const curve = &run->engine.curve;
    for (size_t i = 0; i < run->model_count; i++) {
        for (uint8_t t = 0; t < curve->tau_count; t++) {
            if (run->model[i].m == curve->taus[t]) {
                return true;
            }
        }
    }
    return (run->model_count == 0U) ||
           sim_fail(&run->error,
                    "--model-table: none of its cluster sizes is among those of the results");
}

/* ends: the ascending ends of the runs without a gap inside; the last is `count`. */
static void add_segments(spectrum_t *spectrum, const double *values, size_t count,
                         const size_t *ends)
{
    size_t end = 0;
    for (size_t i = 0; i < spectrum_places(spectrum, count); i++) {
        const size_t first = (size_t)spectrum_place(spectrum, count, i);
        while (ends[end] <= first) {
            end++;
        }
        if (first + spectrum->segment <= ends[end]) {
            spectrum_add(spectrum, values + first);
        }
    }
}

bool davar_python_learn(davar_python_t *run, const double *values, size_t count, const size_t *ends,
                        char *option, size_t size)
{
    char text[LEARN_TEXT];
    const bool counted = (run->options.arith == ARITH_FIXED) && (run->options.setup.lsb > 0.0);
    spectrum_t spectrum = {0};
    if (!spectrum_open(&spectrum, count)) {
        return sim_fail(&run->error, "out of memory");
    }
    add_segments(&spectrum, values, count, ends);
    run->learned = learn_filter(&spectrum, counted ? (1.0 / 12.0) : 0.0);
    learn_option(&run->learned, text);
    (void)snprintf(option, size, "%s", text);
    spectrum_close(&spectrum);
    return true;
}

bool davar_python_start(davar_python_t *run, double rate_hz, double low, double high)
{
    const char *const name = "x";
    run->extent = (extent_t){.low = low, .high = high};
    run->quantisation = quantise_plan(&run->options, &run->extent);
    const timing_t timing = {.rate_hz = rate_hz, .breaks = UINT16_MAX};
    if (!engine_start(&run->engine, &run->settings, &run->quantisation, &timing, 1U, &run->learned,
                      &run->options, &run->error) ||
        !floors_open(&run->floors, &run->options, &run->engine, &name, &run->error) ||
        ((run->fit_every > 0U) &&
         !batches_open(&run->batches, &run->options, &run->engine, &run->error)) ||
        !model_fits(run)) {
        return false;
    }
    run->plans = calloc(PLANS, sizeof *run->plans);
    if (run->plans == NULL) {
        return sim_fail(&run->error, "out of memory");
    }
    const fields_setup_t setup = {.taus = run->engine.curve.taus,
                                  .tau_count = run->engine.curve.tau_count,
                                  .monitored = (run->model_count > 0U),
                                  .unfitted = (run->fit_every == 0U),
                                  .tracked =
                                      (davar_law_id(&run->engine.config) == DAVAR_LAW_ID_GLR),
                                  .floored = run->options.floor,
                                  .details = run->options.details};
    fields_make(&run->fields, &setup);
    return true;
}

size_t davar_python_columns(const davar_python_t *run)
{
    return run->fields.count;
}

const char *davar_python_column(const davar_python_t *run, size_t i)
{
    return run->fields.field[i].name;
}

/* Null: no --longest-tau. */
static davar_cascade_t *cascade_of(const davar_python_t *run)
{
    return run->engine.channels->cascade;
}

void davar_python_gap(davar_python_t *run, uint32_t missing)
{
    engine_gap(&run->engine, 0U, missing);
    run->is_gap = true;
}

static void convert(davar_python_t *run, const double *values, size_t count)
{
    const davar_port_number_t number = run->engine.number;
    for (size_t i = 0; i < count; i++) {
        if (number == DAVAR_PORT_F32) {
            run->samples.f32[i] = (float)values[i];
        } else if (number == DAVAR_PORT_Q15) {
            run->samples.q15[i] = (int16_t)quantise_count(&run->quantisation, values[i]);
        } else {
            run->samples.q31[i] = quantise_count(&run->quantisation, values[i]);
        }
    }
}

/* The samples from `from` on, as the member of their number type. */
static davar_port_samples_t converted(const davar_python_t *run, size_t from)
{
    davar_port_samples_t samples = {0};
    switch (run->engine.number) {
    case DAVAR_PORT_Q15:
        samples.q15 = run->samples.q15 + from;
        break;
    case DAVAR_PORT_Q31:
        samples.q31 = run->samples.q31 + from;
        break;
    case DAVAR_PORT_F32:
    default:
        samples.f32 = run->samples.f32 + from;
        break;
    }
    return samples;
}

static size_t push_some(davar_python_t *run, size_t from, size_t count)
{
    davar_t *davar = run->engine.instances;
    if (run->engine.centred != NULL) {
        return centred_push(run->engine.centred[0], converted(run, 0U), from, from + count);
    }
    switch (run->engine.number) {
    case DAVAR_PORT_Q15:
        return davar_push_until_result_q15(davar, run->samples.q15 + from, count);
    case DAVAR_PORT_Q31:
        return davar_push_until_result_q31(davar, run->samples.q31 + from, count);
    case DAVAR_PORT_F32:
    default:
        return davar_push_until_result_f32(davar, run->samples.f32 + from, count);
    }
}

/* Copies the plan at its first use, because most windows need few of them. */
static davar_plan_t *plan_of(davar_python_t *run, uint32_t window_samples)
{
    davar_plan_t *const plan = &run->plans[window_samples % PLANS];
    if (plan->sizes == 0U) {
        *plan = run->engine.filtered->plan;
    }
    return plan;
}

/* Fits the result at its turn: every fit_every-th epoch. True if it did. */
static bool fit_if_due(davar_python_t *run)
{
    if ((run->fit_every == 0U) || (run->unfitted > 0U)) {
        run->unfitted -= (run->unfitted > 0U) ? 1U : 0U;
        return false;
    }
    run->unfitted = run->fit_every - 1U;
    davar_plan_t *const plan = plan_of(run, run->result.window_samples);
    davar_fit(plan, run->engine.config.rate_hz, &run->result);
    (void)davar_fit_flat(plan, run->engine.config.rate_hz, &run->result);
    return true;
}

static double number_of(const cell_t *cell)
{
    switch (cell->kind) {
    case CELL_INTEGER:
        return (double)cell->integer;
    case CELL_TIME:
    case CELL_NUMBER:
        return cell->number;
    case CELL_ABSENT:
    default:
        return (double)NAN;
    }
}

/* The free rows of a table of columns. */
typedef struct {
    double *first;
    size_t stride; /* from column to column */
    size_t room;
    size_t written;
} rows_t;

/* The cells of the columns from `first` to before `end`. */
static void write_cells(const davar_python_t *run, const epoch_row_t *epoch, bool fitted,
                        const rows_t *rows, size_t row, size_t first, size_t end)
{
    double *cell = rows->first + first * rows->stride + row;
    for (size_t i = first; i < end; i++, cell += rows->stride) {
        const field_t *field = &run->fields.field[i];
        if (field->of_fit && !fitted) {
            *cell = (double)NAN;
        } else {
            const cell_t shown = field->show(epoch, field->index);
            *cell = number_of(&shown);
        }
    }
}

/* Writes run->result to a row, except for the deviations. */
static void write_row(davar_python_t *run, bool fitted, const rows_t *rows, size_t row)
{
    const bool monitored = (run->model_count > 0U);
    if (monitored) {
        davar_monitor_update(&run->monitor, &run->result, &run->misfit);
    }
    batches_apply(&run->batches, 0U, &run->result);
    const epoch_row_t epoch = {.result = &run->result,
                               .report = &run->report,
                               .misfit = monitored ? &run->misfit : NULL,
                               .floor = floors_at(&run->floors, 0U, run->result.epoch),
                               .time_s = (double)NAN};
    const fields_t *const fields = &run->fields;
    write_cells(run, &epoch, fitted, rows, row, 0U, fields->first_adev);
    write_cells(run, &epoch, fitted, rows, row, fields->first_adev + run->engine.curve.tau_count,
                fields->count);
}

/* NaN without a difference. */
static void write_deviations(const davar_python_t *run, const rows_t *rows, size_t row)
{
    double *adev = rows->first + run->fields.first_adev * rows->stride + row;
    for (uint8_t t = 0; t < run->engine.curve.tau_count; t++, adev += rows->stride) {
        *adev = run->result.tau[t].adev;
    }
}

static bool take(davar_python_t *run)
{
    if (run->engine.centred != NULL) {
        return centred_take(run->engine.centred[0], &run->result);
    }
    if (!davar_take(run->engine.instances, &run->result)) {
        return false;
    }
    davar_glr_report(run->engine.instances, &run->report);
    return true;
}

static bool flush(davar_python_t *run)
{
    return (run->engine.centred != NULL) ? centred_flush(run->engine.centred[0])
                                         : davar_flush(run->engine.instances);
}

static void take_row(davar_python_t *run, rows_t *rows)
{
    if (take(run)) {
        if (cascade_of(run) != NULL) {
            (void)davar_cascade_append(cascade_of(run), &run->result);
        }
        write_deviations(run, rows, rows->written);
        write_row(run, fit_if_due(run), rows, rows->written);
        rows->written++;
    }
}

/* Pushes one chunk while there is room for rows. Returns the number of samples consumed. */
static size_t push_chunk(davar_python_t *run, size_t count, rows_t *rows)
{
    size_t done = 0;
    while ((done < count) && (rows->written < rows->room)) {
        const size_t more = push_some(run, done, count - done);
        if (more == 0U) {
            break;
        }
        if (cascade_of(run) != NULL) {
            davar_curve_push(cascade_of(run), run->engine.number, converted(run, 0U), done, more);
        }
        const davar_port_samples_t pushed = converted(run, done);
        if (!floors_push(&run->floors, &pushed, more, run->is_gap, &run->error) ||
            !batches_push(&run->batches, &pushed, more, run->is_gap, &run->error)) {
            break;
        }
        run->is_gap = false;
        done += more;
        take_row(run, rows);
    }
    return done;
}

size_t davar_python_push(davar_python_t *run, const double *values, size_t count, double *first,
                         size_t stride, size_t room, size_t *taken)
{
    rows_t rows = {.stride = stride, .room = room};
    rows.first = first;
    *taken = 0;
    while ((*taken < count) && (rows.written < room)) {
        const size_t left = count - *taken;
        const size_t chunk = (left < CHUNK) ? left : CHUNK;
        convert(run, values + *taken, chunk);
        const size_t done = push_chunk(run, chunk, &rows);
        *taken += done;
        if (done == 0U) {
            break;
        }
    }
    return rows.written;
}

size_t davar_python_flush(davar_python_t *run, double *first, size_t stride, size_t room)
{
    rows_t rows = {.stride = stride, .room = room};
    rows.first = first;
    if (cascade_of(run) != NULL) {
        davar_cascade_flush(cascade_of(run));
    }
    while ((rows.written < room) && flush(run)) {
        take_row(run, &rows);
    }
    return rows.written;
}

/* --- a complete record in one step (slide.h) -------------------------------------------------- */

/* run->result of a row of which the deviations and the flag are written. */
static void slide_result(davar_python_t *run, slide_t *slide, const rows_t *rows, size_t row)
{
    davar_result_t *const result = &run->result;
    const double *adev = rows->first + run->fields.first_adev * rows->stride + row;
    result->epoch = slide_epoch(slide, row);
    result->window_samples = slide_length(slide, row);
    result->mirrored_samples = slide_mirrored(slide, row);
    result->unstable = rows->first[FIELD_UNSTABLE * rows->stride + row] > 0.0;
    for (uint8_t t = 0; t < result->tau_count; t++, adev += rows->stride) {
        result->tau[t] = (davar_adev_t){.m = slide->config->taus[t],
                                        .adev = *adev,
                                        .low = (double)NAN,
                                        .high = (double)NAN,
                                        .edf = (double)NAN};
    }
    slide_count(slide, row, result);
}

/* The cells that a row of a full window without a fit has in common with all others. */
static void learn_alike(davar_python_t *run, const rows_t *rows, size_t row)
{
    for (size_t i = 0; i < run->fields.count; i++) {
        run->alike[i] = rows->first[i * rows->stride + row];
    }
    run->has_alike = true;
}

/* Such rows differ in the epoch, the flag of an unstable window and the deviations; the last two are
 * written. */
static void write_alike(const davar_python_t *run, const slide_t *slide, const rows_t *rows,
                        size_t begin, size_t end)
{
    const fields_t *const fields = &run->fields;
    double *const epoch = rows->first + FIELD_EPOCH * rows->stride;
    for (size_t i = 1U; i < fields->count; i++) {
        double *const column = rows->first + i * rows->stride;
        const bool is_adev = (i - fields->first_adev) < run->engine.curve.tau_count;
        for (size_t row = begin; (row < end) && !is_adev && (i != FIELD_UNSTABLE); row++) {
            column[row] = run->alike[i];
        }
    }
    for (size_t row = begin; row < end; row++) {
        epoch[row] = (double)slide_epoch(slide, row);
    }
}

/* How many rows from this one on need no fit and have a full window, up to `end`. */
static size_t rows_alike(const davar_python_t *run, const slide_t *slide, size_t row, size_t end)
{
    const size_t left = end - row;
    if (!run->has_alike || (slide_length(slide, row) < slide->config->window.longest)) {
        return 0U;
    }
    return ((run->fit_every > 0U) && (run->unfitted < left)) ? run->unfitted : left;
}

static void slide_rows(davar_python_t *run, slide_t *slide, const rows_t *rows, size_t first,
                       size_t end)
{
    slide_next(slide, end - first);
    for (size_t t = 0; t < run->result.tau_count; t++) {
        slide_deviations(slide, t,
                         rows->first + (run->fields.first_adev + t) * rows->stride + first);
    }
    slide_changes(slide, rows->first + FIELD_UNSTABLE * rows->stride + first);
    for (size_t row = first; row < end;) {
        const size_t alike = rows_alike(run, slide, row, end);
        write_alike(run, slide, rows, row, row + alike);
        run->unfitted -= (run->fit_every > 0U) ? (uint32_t)alike : 0U;
        row += alike;
        if (row < end) {
            slide_result(run, slide, rows, row);
            const bool fitted = fit_if_due(run);
            write_row(run, fitted, rows, row);
            if (!fitted && (run->result.window_samples == slide->config->window.longest)) {
                learn_alike(run, rows, row);
            }
            row++;
        }
    }
}

static bool slide_begin(davar_python_t *run, const slide_record_t *record)
{
    slide_t *const slide = &run->slide;
    const bool alone = (cascade_of(run) == NULL) && (run->model_count == 0U) &&
                       !run->options.floor && !run->options.details;
    if (!alone || !slide_open(slide, &run->engine.config, run->settings.is_centred,
                              &run->quantisation, &run->extent, record)) {
        return false;
    }
    run->result = (davar_result_t){.tau_count = slide->config->tau_count,
                                   .unit_per_count = slide->config->unit_per_count,
                                   .kurtosis = (double)NAN,
                                   .contribution = (double)NAN,
                                   .dispersion = (double)NAN};
    return true;
}

size_t davar_python_slide(davar_python_t *run, const double *values, size_t count,
                          const size_t *ends, size_t runs, double *first, size_t stride,
                          size_t room)
{
    slide_t *const slide = &run->slide;
    const slide_record_t record = {values, count, ends, runs};
    rows_t rows = {.stride = stride};
    rows.first = first;
    const size_t begin = run->slid;
    if ((begin == 0U) && !slide_begin(run, &record)) {
        slide_close(slide);
        return 0U;
    }
    const size_t end = ((slide->rows - begin) < room) ? slide->rows : (begin + room);
    while (run->slid < end) {
        const size_t left = end - run->slid;
        const size_t block = (left < SLIDE_BLOCK) ? left : SLIDE_BLOCK;
        slide_rows(run, slide, &rows, run->slid, run->slid + block);
        run->slid += block;
    }
    return run->slid - begin;
}

void davar_python_health(const davar_python_t *run, uint32_t *counters)
{
    const davar_health_t health = engine_health_of(&run->engine, 0U);
    const uint32_t all[] = {health.gaps,       health.missing,  health.saturated,
                            health.not_finite, health.restarts, health.missed,
                            health.cuts,       health.alarms,   health.shocks};
    memcpy(counters, all, sizeof all);
}
