/* davar-sim - output stream. */
#include "output/output.h"

#include "common/stop.h"
#include "output/csv_out.h"
#include "output/jsonl_out.h"
#include "output/table_out.h"

bool output_open(output_t *output, const options_t *options, const engine_t *engine,
                 const selection_t *selection, sim_error_t *error)
{
    output->format = options->out;
    output->selection = selection;
    output->raw = options->setup.raw;
    output->flush_rows = (options->pace > 0.0);
    output->rows = 0;
    const fields_setup_t setup = {.taus = engine->curve.taus,
                                  .tau_count = engine->curve.tau_count,
                                  .monitored = (options->model_table != NULL),
                                  .tracked = (options->setup.law == DAVAR_LAW_ID_GLR),
                                  .floored = options->floor,
                                  .details = options->details};
    fields_make(&output->fields, &setup);
    return floors_open(&output->floors, options, engine, selection->name, error) &&
           ((options->out == OUT_LINK) || /* frames have the limits of the fit */
            batches_open(&output->batches, options, engine, error)) &&
           watch_open(&output->watch, options, engine, error) &&
           ((options->out != OUT_LINK) || wire_out_open(&output->wire, options, engine, error));
}

static void write_csv(output_t *output, size_t channel, const epoch_row_t *row)
{
    const bool named = (output->selection->count > 1U);
    if (output->rows == 1U) {
        csv_out_header(&output->text, &output->fields, named);
    }
    csv_out_row(&output->text, &output->fields, named ? output->selection->name[channel] : NULL,
                row);
}

static void note_reached(output_t *output, const davar_result_t *result)
{
    for (uint8_t t = output->reached; t < result->tau_count; t++) {
        output->reached = (result->tau[t].differences > 0U) ? (uint8_t)(t + 1U) : output->reached;
    }
}

/* A filter leaves no angle random walk. */
static bool is_withheld(const davar_result_t *result)
{
    return (result->noise == DAVAR_NOISE_FILTERED) &&
           !result->coefficient[DAVAR_ANGLE_RANDOM_WALK].present;
}

static void write_table(output_t *output, size_t channel, const epoch_row_t *row)
{
    if (output->rows == 1U) {
        table_out_header(&output->text, row->floor != NULL);
    }
    table_out_row(&output->text, output->selection->name[channel], row);
}

bool output_row(output_t *output, size_t channel, const epoch_row_t *plain, sim_error_t *error)
{
    davar_result_t own;
    if (output->batches.engine != NULL) {
        own = *plain->result;
        batches_apply(&output->batches, channel, &own);
    }
    const epoch_row_t watched = {.result = (output->batches.engine != NULL) ? &own : plain->result,
                                 .report = plain->report,
                                 .misfit = watch_compare(&output->watch, channel, plain->result),
                                 .floor = floors_at(&output->floors, channel, plain->result->epoch),
                                 .time_s = plain->time_s};
    const epoch_row_t *row = &watched;
    if (stop_requested(error)) {
        return false;
    }
    output->rows++;
    output->coarse += (plain->result->noise == DAVAR_NOISE_COARSE) ? 1U : 0U;
    output->filtered += is_withheld(plain->result) ? 1U : 0U;
    note_reached(output, plain->result);
    switch (output->format) {
    case OUT_LINK:
        return wire_out_result(&output->wire, channel, row, error);
    case OUT_JSONL:
        jsonl_out_row(&output->text, &output->fields, output->selection->name[channel], row);
        break;
    case OUT_TABLE:
        write_table(output, channel, row);
        break;
    case OUT_CSV:
    default:
        write_csv(output, channel, row);
        break;
    }
    return rows_out_take(&output->text, output->flush_rows, error);
}

bool output_samples(output_t *output, const raw_run_t *run, bool is_gap, sim_error_t *error)
{
    return floors_push(&output->floors, run->samples, run->count, is_gap, error) &&
           batches_push(&output->batches, run->samples, run->count, is_gap, error) &&
           (!output->raw || wire_out_raw(&output->wire, run, error));
}

bool output_finish(output_t *output, sim_error_t *error)
{
    const bool is_sent = (output->format != OUT_LINK) || wire_out_finish(&output->wire, error);
    return is_sent && rows_out_take(&output->text, true, error);
}

void output_close(output_t *output)
{
    rows_out_close(&output->text);
    wire_out_close(&output->wire);
    watch_close(&output->watch);
    floors_close(&output->floors);
    batches_close(&output->batches);
}
