/* davar-sim - the command line: its table, and options that exclude each other. */
#include "options/options.h"

#include "davar_link.h"

#include <stdlib.h>
#include <unistd.h>

static const davar_dialect_t *dialect_of(const options_t *options)
{
    davar_telemetry_address_t unused;
    return (options->out == OUT_LINK) ? davar_link_dialect(options->link, 0U, &unused) : NULL;
}

/* davar's own frames. */
static bool sends_frames(const options_t *options)
{
    return (options->out == OUT_LINK) && (dialect_of(options) == NULL);
}

static bool check_floor_option(const options_t *options, sim_error_t *error)
{
    const davar_dialect_t *const dialect = dialect_of(options);
    if (options->device != NULL) {
        return sim_fail(error, "--floor: cannot be used with --device");
    }
    return (dialect == NULL) || (dialect == &davar_mavlink) ||
           sim_fail(error,
                    "--floor: needs --out csv, jsonl, table, can:.., slcan:.. or mavlink:..");
}

static bool check_device(const options_t *options, sim_error_t *error)
{
    if (options->pace > 0.0) {
        return sim_fail(error,
                        "--pace: cannot be used with --device, because a device has its own clock");
    }
    if (options->mode_given && (options->mode == MODE_CENTRED)) {
        return sim_fail(error, "--mode centred: cannot be used with --device, because a device "
                               "computes trailing windows; give --mode trailing");
    }
    return !options->setup.raw ||
           sim_fail(error, "--raw: cannot be used with --device, which reads all samples before "
                           "its first result");
}

static bool check(const options_t *options, sim_error_t *error)
{
    if (options->recording == NULL) {
        return sim_fail(error, "no recording given (see --help)");
    }
    if ((options->device != NULL) && !check_device(options, error)) {
        return false;
    }
    if (options->floor && !check_floor_option(options, error)) {
        return false;
    }
    if (options->details && (options->out == OUT_TABLE)) {
        return sim_fail(error, "--details: needs --out csv or jsonl");
    }
    return (options->setup.frames_only == NULL) || sends_frames(options) ||
           sim_fail(error, "--%s: needs --out can:IFACE or slcan:PATH", options->setup.frames_only);
}

command_status_t options_parse(options_t *options, int argc, char **argv, sim_error_t *error)
{
    *options = options_usual;
    const command_status_t status = command_read(&options_command, options, argc, argv, error);
    if (!options->out_given && !options->details && (isatty(STDOUT_FILENO) == 1)) {
        options->out = OUT_TABLE;
    }
    return ((status == COMMAND_RUN) && !check(options, error)) ? COMMAND_BAD : status;
}

void options_free(options_t *options)
{
    for (size_t c = 0; c < options->column_count; c++) {
        free(options->columns[c]);
    }
    options->column_count = 0;
}
