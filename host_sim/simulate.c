/* davar-sim - the stages in the order of the data: settings, recording (pass 1), rate, counts,
 * instances, replay (pass 2). Nothing is printed before all stages have accepted the recording. */
#include "simulate.h"

#include "common/stop.h"
#include "davar_node.h"
#include "instances/engine.h"
#include "learning/channels.h"
#include "output/report.h"
#include "recording/torn.h"
#include "replay/device.h"
#include "replay/host.h"
#include "replay/replay.h"

#include <inttypes.h>
#include <stdlib.h>

/* The state of a run. It is large and points into itself: allocated once, never moved. */
typedef struct {
    const options_t *options;
    settings_t settings;
    recording_t recording;
    timing_t timing;
    quantisation_t quantisation;
    uint64_t torn[OPTIONS_COLUMNS_MAX];     /* with --skip-torn-reads: torn reads */
    learned_t learned[OPTIONS_COLUMNS_MAX]; /* with --bandwidth auto */
    engine_t engine;
    output_t output;
    replay_t replay;
    davar_node_t node;
    progress_t progress;
    davar_health_t health; /* of all channels, at the end of the run */
} run_t;

static bool fail_short(const run_t *run, sim_error_t *error)
{
    return sim_fail(error,
                    "%s: too short: %" PRIu64 " samples, but one epoch needs at least %" PRIu64
                    " (see --window-max)",
                    run->options->recording, run->recording.rows,
                    settings_samples_needed(&run->settings));
}

static bool skip_torn(run_t *run, sim_error_t *error)
{
    return torn_skip(run->torn, &run->recording, &run->timing, error) &&
           ((run->recording.rows >= settings_samples_needed(&run->settings)) ||
            fail_short(run, error));
}

static bool load(run_t *run, sim_error_t *error)
{
    const options_t *options = run->options;
    if (!settings_make(&run->settings, options, error) ||
        !recording_load(&run->recording, options, &run->progress, error)) {
        return false;
    }
    if (run->recording.rows < settings_samples_needed(&run->settings)) {
        return fail_short(run, error);
    }
    run->quantisation = quantise_plan(options, &run->recording.extent);
    return timing_find(&run->timing, &run->recording, options, error) &&
           (!options->setup.skips_torn || skip_torn(run, error)) &&
           (!options->learns_filter ||
            learn_channels(run->learned, &run->recording, &run->timing, options, error)) &&
           engine_start(&run->engine, &run->settings, &run->quantisation, &run->timing,
                        run->recording.selection.count, run->learned, options, error) &&
           output_open(&run->output, options, &run->engine, &run->recording.selection, error);
}

static bool step_to_the_end(run_t *run)
{
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    while ((state == DAVAR_NODE_RUNNING) || (state == DAVAR_NODE_IDLE)) {
        state = davar_node_step(&run->node);
        if (state == DAVAR_NODE_IDLE) {
            replay_wait(&run->replay);
        }
    }
    return state == DAVAR_NODE_DONE;
}

static bool replay(run_t *run, sim_error_t *error)
{
    const replay_setup_t setup = {.recording = &run->recording,
                                  .timing = &run->timing,
                                  .quantisation = &run->quantisation,
                                  .number = run->engine.number,
                                  .instances =
                                      run->settings.is_centred ? NULL : run->engine.instances,
                                  .output = &run->output,
                                  .progress = &run->progress,
                                  .times_real_time = run->options->pace};
    if (!replay_open(&run->replay, &setup, error)) {
        return false;
    }
    stop_catch();
    if (run->options->device != NULL) {
        return device_replay(run->options->device, &run->replay, &run->engine, &run->health, error);
    }
    if (run->settings.is_centred) {
        const bool good = host_replay(&run->replay, &run->engine);
        run->health = engine_health(&run->engine);
        return good;
    }
    const davar_port_t port = replay_port(&run->replay);
    davar_node_init(&run->node, run->engine.channels, run->engine.count, &port);
    const bool done = step_to_the_end(run);
    run->health = engine_health(&run->engine);
    return done;
}

static bool finish(run_t *run, sim_error_t *error)
{
    progress_clear(&run->progress);
    if (run->output.rows == 0U) {
        return fail_short(run, error);
    }
    report_counters(&run->health);
    report_coarse(run->output.coarse, run->output.rows);
    if (run->options->setup.longest_tau_s > 0.0) {
        report_unreached(run->engine.curve.taus, run->engine.curve.tau_count, run->output.reached);
    }
    report_filtered(run->output.filtered, run->output.rows, run->engine.declared != NULL);
    return output_finish(&run->output, error);
}

static bool work(run_t *run, sim_error_t *error)
{
    progress_start(&run->progress, run->options->progress);
    if (!load(run, error)) {
        return false;
    }
    progress_clear(&run->progress);
    report_notes(run->options, &run->recording, &run->timing, &run->quantisation);
    if (run->options->setup.skips_torn) {
        report_torn(&run->recording.selection, run->torn);
    }
    if (run->options->learns_filter) {
        report_learned(&run->recording.selection, run->learned, run->timing.rate_hz);
    }
    return replay(run, error) && finish(run, error);
}

bool simulate(const options_t *options, sim_error_t *error)
{
    run_t *run = calloc(1U, sizeof *run);
    if (run == NULL) {
        return sim_fail(error, "out of memory");
    }
    run->options = options;
    const bool good = work(run, error);
    progress_clear(&run->progress);
    replay_close(&run->replay);
    output_close(&run->output);
    engine_free(&run->engine);
    timing_close(&run->timing);
    recording_free(&run->recording);
    free(run);
    return good;
}
