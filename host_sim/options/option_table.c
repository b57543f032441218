/* davar-sim - option handlers, in the order of the help text. */
#include "options/option_table.h"

#include "options/value.h"

#include <stdlib.h>
#include <string.h>

#define TAUS_WANTED_DEFAULT 12U

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

bool option_add_columns(options_t *options, const char *text, sim_error_t *error)
{
    const char *name = text;
    for (;;) {
        const size_t length = strcspn(name, ",");
        if (!add_column(options, name, length, error)) {
            return false;
        }
        if (name[length] == '\0') {
            return true;
        }
        name += length + 1U;
    }
}

static bool apply_rate(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("rate", text, &options->rate_hz, error);
}

static bool apply_bandwidth(options_t *options, const char *text, sim_error_t *error)
{
    options->learns_filter = (strcmp(text, "auto") == 0);
    options->declares_filter =
        !options->learns_filter && davar_bandwidth_read(text, &options->bandwidth);
    return options->learns_filter || options->declares_filter ||
           sim_fail(error, "--bandwidth: expected " DAVAR_BANDWIDTH_FORMS ", or auto, found '%s'",
                    text);
}

static bool apply_gap(options_t *options, const char *text, sim_error_t *error)
{
    if (!value_positive("gap", text, &options->gap_factor, error)) {
        return false;
    }
    return (options->gap_factor > 1.0) ||
           sim_fail(error, "--gap: must be above 1, found '%s'", text);
}

static bool apply_arith(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"fixed", "float"};
    size_t choice = 0;
    const bool good = value_choice("arith", text, WORDS, 2, &choice, error);
    options->arith = (arith_t)choice;
    return good;
}

static bool apply_lsb(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("lsb", text, &options->lsb, error);
}

static bool apply_bits(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"16", "24", "32"};
    size_t choice = 0;
    const bool good = value_choice("bits", text, WORDS, 3, &choice, error);
    options->bits = 16U + 8U * (uint32_t)choice;
    return good;
}

static bool apply_full_scale(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("full-scale", text, &options->full_scale, error);
}

static bool apply_law(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"fixed", "kurtosis", "or", "and", "glr"};
    size_t choice = 0;
    const bool good = value_choice("law", text, WORDS, 5, &choice, error);
    options->law = (davar_law_id_t)choice;
    return good;
}

static bool apply_false_alarms(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("false-alarms-per-hour", text, &options->false_alarms_per_hour, error);
}

static bool apply_cut_interval(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("cut-interval", text, &options->cut_interval_s, error);
}

static bool apply_mode(options_t *options, const char *text, sim_error_t *error)
{
    options->mode_given = true;
    static const char *const WORDS[] = {"trailing", "centred"}; /* in the order of window_mode_t */
    size_t choice = 0;
    const bool good = value_choice("mode", text, WORDS, 2, &choice, error);
    options->mode = (window_mode_t)choice;
    return good;
}

static bool apply_count(const char *option, const char *text, optional_u32_t *count,
                        sim_error_t *error)
{
    count->given = true;
    return value_u32(option, text, &count->value, error);
}

static bool apply_window_max(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("window-max", text, &options->window_max, error);
}

static bool apply_window_min(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("window-min", text, &options->window_min, error);
}

static bool apply_segment(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("segment", text, &options->segment, error);
}

static bool apply_grow(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("grow", text, &options->grow, error);
}

static bool apply_shrink(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("shrink", text, &options->shrink, error);
}

static bool apply_stride(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("stride", text, &options->stride, error);
}

static bool apply_engine(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"auto", "grid"};
    size_t choice = 0;
    const bool good = value_choice("engine", text, WORDS, 2, &choice, error);
    options->uses_grid = (choice == 1U);
    return good;
}

static bool apply_shock_blocks(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("shock-blocks", text, &options->shock_blocks, error);
}

static bool refuse_long_cluster(options_t *options, const char *text, sim_error_t *error)
{
    (void)options;
    (void)text;
    return sim_fail(error,
                    "--long-cluster: removed; use --longest-tau to see slow changes of the noise");
}

static bool apply_block(options_t *options, const char *text, sim_error_t *error)
{
    return apply_count("block", text, &options->block, error);
}

static bool apply_kurtosis(options_t *options, const char *text, sim_error_t *error)
{
    options->kurtosis.given = true;
    return value_range("kurtosis", text, &options->kurtosis.low, &options->kurtosis.high, error);
}

static bool apply_contribution(options_t *options, const char *text, sim_error_t *error)
{
    options->contribution.given = true;
    return value_range("contribution", text, &options->contribution.low,
                       &options->contribution.high, error);
}

static bool apply_unstable_rate(options_t *options, const char *text, sim_error_t *error)
{
    if (!value_positive("unstable-rate", text, &options->unstable_rate, error)) {
        return false;
    }
    return ((options->unstable_rate >= 1e-4) && (options->unstable_rate <= 0.1)) ||
           sim_fail(error, "--unstable-rate: a share from 0.0001 to 0.1 expected, found '%s'",
                    text);
}

static bool apply_geometric(options_t *options, const char *text, sim_error_t *error)
{
    options->taus_kind = TAUS_GEOMETRIC;
    options->taus_wanted = TAUS_WANTED_DEFAULT;
    if ((*text == ':') && !value_u32("taus", text + 1, &options->taus_wanted, error)) {
        return false;
    }
    if ((options->taus_wanted == 0U) || (options->taus_wanted > DAVAR_TAUS_MAX)) {
        return sim_fail(error,
                        "--taus: geometric:N with N from 1 to %u expected, found 'geometric%s'",
                        DAVAR_TAUS_MAX, text);
    }
    return true;
}

static bool apply_taus(options_t *options, const char *text, sim_error_t *error)
{
    const size_t word = sizeof "geometric" - 1U;
    if (strcmp(text, "octave") == 0) {
        options->taus_kind = TAUS_OCTAVE;
        return true;
    }
    if ((strncmp(text, "geometric", word) == 0) && ((text[word] == '\0') || (text[word] == ':'))) {
        return apply_geometric(options, text + word, error);
    }
    if ((text[0] < '0') || (text[0] > '9')) {
        return sim_fail(error, "--taus: octave, geometric[:N] or N,N,... expected, found '%s'",
                        text);
    }
    options->taus_kind = TAUS_LIST;
    return value_u32_list("taus", text, options->taus, DAVAR_TAUS_MAX, &options->tau_count, error);
}

static bool apply_longest_tau(options_t *options, const char *text, sim_error_t *error)
{
    return value_positive("longest-tau", text, &options->longest_tau_s, error);
}

static bool apply_out(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"csv", "jsonl"};
    static const char *const LINKS[] = {"can:", "slcan:", "mavlink:", "dronecan:", "cyphal:"};
    for (size_t i = 0; i < sizeof LINKS / sizeof LINKS[0]; i++) {
        if (strncmp(text, LINKS[i], strlen(LINKS[i])) == 0) {
            options->out = OUT_LINK;
            options->link = text;
            return true;
        }
    }
    for (size_t i = 0; i < 2U; i++) {
        if (strcmp(text, WORDS[i]) == 0) {
            options->out = (out_t)i;
            return true;
        }
    }
    return sim_fail(error,
                    "--out: one of csv, jsonl, can:IFACE, slcan:PATH, mavlink:.., dronecan:IFACE, "
                    "cyphal:IFACE expected, found '%s'",
                    text);
}

static bool apply_can_base(options_t *options, const char *text, sim_error_t *error)
{
    char *end = NULL;
    const unsigned long value = strtoul(text, &end, 16);
    const size_t prefix = ((text[0] == '0') && ((text[1] == 'x') || (text[1] == 'X'))) ? 2U : 0U;
    const bool digits = (strspn(text + prefix, "0123456789abcdefABCDEF") == strlen(text + prefix));
    if (!digits || (text[prefix] == '\0') || (value > DAVAR_CAN_LAST_ID)) {
        return sim_fail(
            error, "--can-base: a hexadecimal identifier up to 7F0 expected, found '%s'", text);
    }
    options->can_base = (uint32_t)value;
    options->frames_only = "can-base";
    return true;
}

static bool apply_can_content(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"summary", "full", "intervals", "fd"};
    static const uint32_t CONTENT[] = {
        0U, DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS,
        DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS | DAVAR_SEND_INTERVALS, DAVAR_SEND_FD};
    size_t choice = 0;
    const bool good = value_choice("can-content", text, WORDS, 4, &choice, error);
    options->can_content = CONTENT[choice];
    options->frames_only = "can-content";
    return good;
}

static bool apply_model_table(options_t *options, const char *text, sim_error_t *error)
{
    options->model_table = text;
    return (text[0] != '\0') || sim_fail(error, "--model-table: needs a file name");
}

static bool apply_device(options_t *options, const char *text, sim_error_t *error)
{
    options->device = text;
    return (text[0] != '\0') || sim_fail(error, "--device: needs a command");
}

static bool apply_baud(options_t *options, const char *text, sim_error_t *error)
{
    return value_u32("baud", text, &options->baud, error);
}

static bool apply_pace(options_t *options, const char *text, sim_error_t *error)
{
    if (strcmp(text, "max") == 0) {
        options->pace = 0.0;
        return true;
    }
    if (strcmp(text, "realtime") == 0) {
        options->pace = 1.0;
        return true;
    }
    if (!value_positive("pace", text, &options->pace, error)) {
        return sim_fail(error, "--pace: max, realtime or a number above zero expected, found '%s'",
                        text);
    }
    return true;
}

static bool apply_progress(options_t *options, const char *text, sim_error_t *error)
{
    static const char *const WORDS[] = {"auto", "always", "never"};
    size_t choice = 0;
    const bool good = value_choice("progress", text, WORDS, 3, &choice, error);
    options->progress = (show_t)choice;
    return good;
}

const option_entry_t OPTION_TABLE[] = {
    {"column", option_add_columns},
    {"rate", apply_rate},
    {"bandwidth", apply_bandwidth},
    {"gap", apply_gap},
    {"skip-torn-reads", NULL},
    {"arith", apply_arith},
    {"lsb", apply_lsb},
    {"bits", apply_bits},
    {"full-scale", apply_full_scale},
    {"law", apply_law},
    {"policy", apply_law}, /* in older scripts */
    {"false-alarms-per-hour", apply_false_alarms},
    {"cut-interval", apply_cut_interval},
    {"shock-blocks", apply_shock_blocks},
    {"block", apply_block},
    {"long-cluster", refuse_long_cluster},
    {"mode", apply_mode},
    {"window-max", apply_window_max},
    {"window-min", apply_window_min},
    {"segment", apply_segment},
    {"kurtosis", apply_kurtosis},
    {"contribution", apply_contribution},
    {"unstable-rate", apply_unstable_rate},
    {"grow", apply_grow},
    {"shrink", apply_shrink},
    {"taus", apply_taus},
    {"longest-tau", apply_longest_tau},
    {"stride", apply_stride},
    {"engine", apply_engine},
    {"out", apply_out},
    {"can-base", apply_can_base},
    {"can-content", apply_can_content},
    {"raw", NULL},
    {"baud", apply_baud},
    {"model-table", apply_model_table},
    {"device", apply_device},
    {"details", NULL},
    {"pace", apply_pace},
    {"progress", apply_progress},
    {"help", NULL},
    {"version", NULL},
    {NULL, NULL},
};
