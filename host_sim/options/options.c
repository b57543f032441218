/* davar-sim - reads the command line with getopt_long. */
#include "options/options.h"

#include "davar_link.h"
#include "options/option_table.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#define OPTIONS_MAX 64
#define ASCII_END 128
#define CODE_FIRST 256 /* getopt codes of the table entries; smaller codes are characters */

/* Derives the input of getopt_long from the table. */
static void fill_long_options(struct option *long_options)
{
    size_t i = 0;
    for (; (i < OPTIONS_MAX) && (OPTION_TABLE[i].name != NULL); i++) {
        long_options[i] = (struct option){
            .name = OPTION_TABLE[i].name,
            .has_arg = (OPTION_TABLE[i].apply != NULL) ? required_argument : no_argument,
            .val = CODE_FIRST + (int)i};
    }
    long_options[i] = (struct option){0};
}

static options_status_t apply_flag(options_t *options, const char *name)
{
    if (strcmp(name, "help") == 0) {
        return OPTIONS_HELP;
    }
    if (strcmp(name, "version") == 0) {
        return OPTIONS_VERSION;
    }
    if (strcmp(name, "raw") == 0) {
        options->raw = true;
        options->frames_only = "raw";
    } else if (strcmp(name, "skip-torn-reads") == 0) {
        options->skips_torn = true;
    } else {
        options->details = true;
    }
    return OPTIONS_RUN;
}

static options_status_t apply_entry(options_t *options, const option_entry_t *entry,
                                    sim_error_t *error)
{
    if (entry->apply == NULL) {
        return apply_flag(options, entry->name);
    }
    return entry->apply(options, optarg, error) ? OPTIONS_RUN : OPTIONS_BAD;
}

/* REC, or after REC one more column of "--column NAME". */
static bool apply_word(options_t *options, bool after_column, const char *word, sim_error_t *error)
{
    if (options->recording == NULL) {
        options->recording = word;
        return true;
    }
    if (after_column) {
        return option_add_columns(options, word, error);
    }
    return sim_fail(error, "unexpected argument '%s' (one recording only; see --help)", word);
}

/* getopt identifies an unknown short option by its character and all others by their position. */
static bool fail_unknown(char **argv, sim_error_t *error)
{
    if ((optopt > 0) && (optopt < ASCII_END)) {
        return sim_fail(error, "unknown option '-%c' (see --help)", optopt);
    }
    if (optopt >= CODE_FIRST) {
        return sim_fail(error, "--%s: takes no value", OPTION_TABLE[optopt - CODE_FIRST].name);
    }
    /* After the first byte of a multi-byte character, getopt is still inside that word. */
    const bool inside = (optopt != 0) && (argv[optind] != NULL) && (argv[optind][0] == '-');
    return sim_fail(error, "unknown option '%s' (see --help)",
                    argv[inside ? optind : (optind - 1)]);
}

static options_status_t walk(options_t *options, int argc, char **argv, sim_error_t *error)
{
    struct option long_options[OPTIONS_MAX + 1];
    fill_long_options(long_options);
    opterr = 0;
    bool after_column = false;
    options_status_t status = OPTIONS_RUN;
    while (status == OPTIONS_RUN) {
        const int code = getopt_long(argc, argv, "-:", long_options, NULL);
        if (code == -1) {
            break;
        }
        if (code == 1) {
            status = apply_word(options, after_column, optarg, error) ? OPTIONS_RUN : OPTIONS_BAD;
        } else if (code >= CODE_FIRST) {
            status = apply_entry(options, &OPTION_TABLE[code - CODE_FIRST], error);
            after_column = (strcmp(OPTION_TABLE[code - CODE_FIRST].name, "column") == 0);
        } else if (code == ':') {
            (void)sim_fail(error, "--%s: needs a value", OPTION_TABLE[optopt - CODE_FIRST].name);
            status = OPTIONS_BAD;
        } else {
            (void)fail_unknown(argv, error);
            status = OPTIONS_BAD;
        }
    }
    return status;
}

/* Words after "--". */
static options_status_t take_rest(options_t *options, int argc, char **argv, sim_error_t *error)
{
    for (int i = optind; i < argc; i++) {
        if (!apply_word(options, false, argv[i], error)) {
            return OPTIONS_BAD;
        }
    }
    if (options->recording == NULL) {
        (void)sim_fail(error, "no recording given (see --help)");
        return OPTIONS_BAD;
    }
    return OPTIONS_RUN;
}

/* davar's own frames. */
static bool sends_frames(const options_t *options)
{
    davar_telemetry_address_t unused;
    return (options->out == OUT_LINK) && (davar_link_dialect(options->link, 0U, &unused) == NULL);
}

options_status_t options_parse(options_t *options, int argc, char **argv, sim_error_t *error)
{
    *options = (options_t){.law = DAVAR_LAW_ID_OR,
                           .mode = MODE_CENTRED,
                           .can_base = DAVAR_CAN_BASE,
                           .can_content = DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS};
    options_status_t status = walk(options, argc, argv, error);
    if (status == OPTIONS_RUN) {
        status = take_rest(options, argc, argv, error);
    }
    if ((status == OPTIONS_RUN) && (options->device != NULL) && (options->pace > 0.0)) {
        (void)sim_fail(error,
                       "--pace: cannot be used with --device, because a device has its own clock");
        status = OPTIONS_BAD;
    }
    if ((status == OPTIONS_RUN) && (options->device != NULL) && options->mode_given &&
        (options->mode == MODE_CENTRED)) {
        (void)sim_fail(error, "--mode centred: cannot be used with --device, because a device "
                              "computes trailing windows; give --mode trailing");
        status = OPTIONS_BAD;
    }
    if ((status == OPTIONS_RUN) && options->raw && (options->device != NULL)) {
        (void)sim_fail(
            error,
            "--raw: cannot be used with --device, which reads all samples before its first result");
        status = OPTIONS_BAD;
    }
    if ((status == OPTIONS_RUN) && (options->frames_only != NULL) && !sends_frames(options)) {
        (void)sim_fail(error, "--%s: needs --out can:IFACE or slcan:PATH", options->frames_only);
        status = OPTIONS_BAD;
    }
    return status;
}

void options_free(options_t *options)
{
    for (size_t c = 0; c < options->column_count; c++) {
        free(options->columns[c]);
    }
    options->column_count = 0;
}
