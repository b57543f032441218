/* davar-sim - the options that davar-node does not have, or has with another help text. The help
 * is the manual. */
#include "options/options.h"

#include <stdlib.h>
#include <string.h>

#define AT(member) offsetof(options_t, member)

const options_t options_usual = {.setup = SETUP_USUAL, .mode = MODE_CENTRED};

static bool add_column(options_t *options, const char *name, size_t length, sim_error_t *error)
{
    if (length == 0U) {
        return sim_fail(error, "--column: empty column name");
    }
    if (options->column_count == OPTIONS_COLUMNS_MAX) {
        return sim_fail(error, "--column: more than %u columns", OPTIONS_COLUMNS_MAX);
    }
    char *copy = malloc(length + 1U);
    if (copy == NULL) {
        return sim_fail(error, "out of memory");
    }
    memcpy(copy, name, length);
    copy[length] = '\0';
    options->columns[options->column_count] = copy;
    options->column_count++;
    return true;
}

static bool read_columns(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    (void)option;
    const char *name = text;
    for (;;) {
        const size_t length = strcspn(name, ",");
        if (!add_column(place, name, length, error)) {
            return false;
        }
        if (name[length] == '\0') {
            return true;
        }
        name += length + 1U;
    }
}

/* REC, or after REC one more column of "--column NAME". */
static bool read_word(void *values, const option_t *last, const char *word, sim_error_t *error)
{
    options_t *const options = values;
    if (options->recording == NULL) {
        options->recording = word;
        return true;
    }
    if ((last != NULL) && (last->read == read_columns)) {
        return read_columns(last, word, options, error);
    }
    return sim_fail(error, "unexpected argument '%s' (one recording only; see --help)", word);
}

static bool read_filter(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    options_t *const options = place;
    setup_t *const setup = &options->setup;
    (void)option;
    options->learns_filter = (strcmp(text, "auto") == 0);
    setup->filter[0] = '\0';
    return options->learns_filter || setup_read_filter(setup, text, "; or auto", error);
}

static bool read_gap(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    return read_positive(option, text, place, error) &&
           ((*(const double *)place > 1.0) ||
            sim_fail(error, "--gap: must be above 1, found '%s'", text));
}

static bool read_bits(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    uint32_t *const bits = place;
    unsigned choice = 0;
    const bool good = read_choice(option, text, &choice, error);
    *bits = 16U + 8U * choice;
    return good;
}

static bool read_mode(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    const option_t in_order = {.name = option->name, .argument = "trailing|centred"};
    options_t *const options = place;
    options->mode_given = true;
    return read_choice(&in_order, text, &options->mode, error);
}

static bool read_out(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    static const char *const WORDS[] = {"csv", "jsonl", "table"};
    static const char *const LINKS[] = {"can:", "slcan:", "mavlink:", "dronecan:", "cyphal:"};
    options_t *const options = place;
    (void)option;
    options->out_given = true;
    for (size_t i = 0; i < sizeof LINKS / sizeof LINKS[0]; i++) {
        if (strncmp(text, LINKS[i], strlen(LINKS[i])) == 0) {
            options->out = OUT_LINK;
            options->link = text;
            return true;
        }
    }
    for (size_t i = 0; i < sizeof WORDS / sizeof WORDS[0]; i++) {
        if (strcmp(text, WORDS[i]) == 0) {
            options->out = (out_t)i;
            return true;
        }
    }
    return sim_fail(
        error,
        "--out: one of csv, jsonl, table, can:IFACE, slcan:PATH, mavlink:.., dronecan:IFACE, "
        "cyphal:IFACE expected, found '%s'",
        text);
}

static bool read_name(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    return (text[0] != '\0') ? read_text(option, text, place, error)
                             : sim_fail(error, "--%s: needs a %s", option->name,
                                        (option->argument[0] == 'F') ? "file name" : "command");
}

static bool read_pace(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    double *const pace = place;
    if ((strcmp(text, "max") == 0) || (strcmp(text, "realtime") == 0)) {
        *pace = (text[0] == 'm') ? 0.0 : 1.0;
        return true;
    }
    return read_positive(option, text, pace, error) ||
           sim_fail(error, "--pace: max, realtime or a number above zero expected, found '%s'",
                    text);
}

static const option_t RECORDING[] = {
    {.help = "Recording"},
    {"column", "NAME ...", read_columns, 0,
     "columns to process: repeat the option, or separate names by\n"
     "commas; after REC also by spaces (default: the first column\n"
     "named gyro_*, otherwise the only one that is not time_s)"},
    {"rate", "HZ", read_positive, AT(setup.rate_hz),
     "sample rate (default: from the median time step)"},
    {"bandwidth", "FILTER", read_filter, 0,
     "what the gyro's noise passed before it was recorded (default:\n"
     "unknown; the fit then withholds its result where the short\n"
     "cluster sizes read low):\n"
     "HZ[:ORDER[:PERCENT]]: an analogue low-pass of 1 or 2 poles\n"
     "(default 2), -3 dB at HZ, known to PERCENT (default 10)\n"
     "biquad:HZ, pt1:HZ, notch:HZ:Q: digital, at the sample rate\n"
     "average[ORDER]:N: ORDER (default 1) moving averages of N samples\n"
     "cic[ORDER]:N: the same, keeping every N-th sample\n"
     "sum:N: sums of N counts (davar_average of the library)\n"
     "ba:B0,B1,..[:A1,A2,..]: coefficients, with A0 = 1\n"
     "FILTER+FILTER: in series, in this order; none: no filter\n"
     "auto: learned for each column from the whole recording, which\n"
     "needs 4352 samples at rest; standard error reports the result"},
    {"gap", "FACTOR", read_gap, AT(gap_factor),
     "a time step longer than FACTOR sample periods is a gap (default\n"
     "1.5; off with --rate)"},
    {"skip-torn-reads", NULL, read_flag, AT(setup.skips_torn),
     "skip rows with a torn register read: a single sample that\n"
     "jumps by a power of two in counts and back. Each makes a gap.\n"
     "Standard error has their number (needs --lsb)"},
    {.help = "Arithmetic"},
    {"arith", "fixed|float", read_choice, AT(arith),
     "integer counts, or float32 samples (default fixed)"},
    {"lsb", "UNIT_PER_COUNT", read_positive, AT(setup.lsb),
     "size of a count in deg/s, or in the unit of the column (default:\n"
     "the smallest power of two with which the recording fits 32 bits)"},
    {"bits", "16|24|32", read_bits, AT(bits),
     "width of a count; a larger value is an error (default 24; needs\n"
     "--lsb)"},
    {"full-scale", "DPS", read_positive, AT(full_scale),
     "with --arith float: larger samples saturate (default: a power of\n"
     "two that covers the recording)"},
    {0},
};

static const option_t MODE[] = {
    {"mode", "centred|trailing", read_mode, 0,
     "the epoch is the centre of the window, or its newest sample\n"
     "(default centred; glr, --device: always trailing)"},
    {0},
};

static const option_t REACH[] = {
    {"longest-tau", "S", read_positive, AT(setup.longest_tau_s),
     "further octaves of cluster sizes, up to S seconds, beyond the\n"
     "window: columns adev_M, and coefficients of the whole curve. Each\n"
     "size remembers its last 34 to 66 clusters before the newest\n"
     "sample, in centred mode too"},
    {0},
};

static const option_t OUTPUT[] = {
    {.help = "Output"},
    {"stride", "K", read_count, AT(setup.stride),
     "one result every K samples (default 1; for a table,\nan eighth of the window)"},
    {"engine", "auto|grid", read_choice, AT(setup.engine),
     "algorithm for strides: equal results, different cost"},
    {"out", "csv|jsonl|table|can:IFACE|slcan:PATH", read_out, 0,
     "\n"
     "format (default table on a terminal, else csv), or a CAN interface or tty\n"
     "for frames; slcan:pty creates a pty and prints its name\n"
     "  --out mavlink:udp:HOST:PORT|mavlink:serial:PATH|dronecan:IFACE|cyphal:IFACE\n"
     "messages of an autopilot (docs/DIALECTS.md)"},
    {"can-base", "HEX", setup_read_base, 0,
     "CAN identifier of the first channel (default 5D0); each further\n"
     "channel adds hexadecimal 10"},
    {"can-content", "summary|full|intervals|fd", setup_read_content, 0,
     "\n"
     "frames of a result: 6 frames, all values (default), also limits,\n"
     "one CAN FD frame"},
    {"raw", NULL, setup_read_raw, 0, "also send frames of the samples, for davarlab live --raw"},
    {"baud", "N", read_whole, AT(setup.baud), "baud rate of the serial line (default: unchanged)"},
    {"model-table", "FILE", read_name, AT(model_table),
     "compare each result with an error model (davarlab export MODEL\n"
     "-o FILE.csv). Adds the columns model_health (above 1: the model\n"
     "does not fit) and model_deviation_M, or frames DAVAR_Monitor"},
    {"device", "COMMAND", read_name, AT(device),
     "run on a device: COMMAND JOB RESULTS (see port/job/davar_job.h\n"
     "and tools/davar-mcu)"},
    {"floor", NULL, read_flag, AT(floor),
     "also the noise between rotor lines and motion (docs/FLIGHT.md):\n"
     "adds floor_deg_per_sqrt_h, its 95 % limits, and floor_why (0: it has\n"
     "a value), or frames DAVAR_Floor. It needs --bandwidth, and --bits to see clipped\n"
     "counts of fewer than 24 bits"},
    {"details", NULL, read_flag, AT(details),
     "more columns: intervals of ADEVs and coefficients, difference counts,\n"
     "gaps, coarse, upper bounds of absent coefficients, the cluster sizes that ARW is from\n"
     "if not from all"},
    {"pace", "max|realtime|X", read_pace, AT(pace),
     "speed as a multiple of real time (default max)"},
    {"progress", "auto|always|never", read_choice, AT(progress),
     "progress on standard error (default auto: on a terminal)"},
    {0},
};

static const char BEFORE[] =
    "usage: davar-sim REC [options]\n"
    "\n"
    "Runs a recorded gyro signal through the davar library. For each window it prints the angle\n"
    "random walk (ARW) and related values. The arithmetic is the same as on a microcontroller.\n"
    "\n"
    "REC: CSV, plain or gzip; '-' is standard input. Optional '# key: value' lines, a header\n"
    "row, then numbers. Columns are named <quantity>_<unit>: time_s, gyro_x_dps, gyro_y_rad_s,\n"
    "gyro_z_counts, temp_degC, ...\n";

static const char AFTER[] =
    "\n"
    "If the window cannot support a value, its field is empty (null in jsonl; in a table, - or\n"
    "an upper limit).\n"
    "Exit status: 0 done, 2 bad recording or option (one line on standard error).\n"
    "\n"
    "Examples\n"
    "  davar-sim flight.csv.gz --lsb 0.05 --stride 100 > arw.csv\n"
    "  davar-sim flight.csv --column gyro_x_dps gyro_y_dps --law fixed --window-max 6000 --out "
    "jsonl\n"
    "  zcat flight.csv.gz | davar-sim - --rate 99.3 --mode trailing --pace realtime\n";

static const option_t *const LISTS[] = {RECORDING, setup_law, MODE,   setup_window,
                                        REACH,     setup_glr, OUTPUT, NULL};

const command_t options_command = {
    .name = "davar-sim", .before = BEFORE, .after = AFTER, .lists = LISTS, .read_word = read_word};
