/* davar programs - the options of davar-sim and davar-node, in the order of the help. */
#include "setup/setup.h"

#include <stdlib.h>
#include <string.h>

#define AT(member) offsetof(setup_t, member)

#define TAUS_WANTED_DEFAULT 12U

static bool read_unstable_rate(const option_t *option, const char *text, void *place,
                               sim_error_t *error)
{
    const double *const rate = place;
    return read_positive(option, text, place, error) &&
           (((*rate >= 1e-4) && (*rate <= 0.1)) ||
            sim_fail(error, "--unstable-rate: a share from 0.0001 to 0.1 expected, found '%s'",
                     text));
}

/* `text` follows the word geometric. */
static bool read_geometric(const option_t *option, const char *text, setup_t *setup,
                           sim_error_t *error)
{
    setup->taus_kind = TAUS_GEOMETRIC;
    setup->taus_wanted = TAUS_WANTED_DEFAULT;
    if ((*text == ':') && !read_whole(option, text + 1, &setup->taus_wanted, error)) {
        return false;
    }
    return ((setup->taus_wanted > 0U) && (setup->taus_wanted <= DAVAR_TAUS_MAX)) ||
           sim_fail(error, "--taus: geometric:N with N from 1 to %u expected, found 'geometric%s'",
                    DAVAR_TAUS_MAX, text);
}

static bool read_taus(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    setup_t *const setup = place;
    const size_t word = sizeof "geometric" - 1U;
    if (strcmp(text, "octave") == 0) {
        setup->taus_kind = TAUS_OCTAVE;
        return true;
    }
    if ((strncmp(text, "geometric", word) == 0) && ((text[word] == '\0') || (text[word] == ':'))) {
        return read_geometric(option, text + word, setup, error);
    }
    if ((text[0] < '0') || (text[0] > '9')) {
        return sim_fail(error, "--taus: octave, geometric[:N] or N,N,... expected, found '%s'",
                        text);
    }
    setup->taus_kind = TAUS_LIST;
    return option_list(option, text, setup->taus, DAVAR_TAUS_MAX, &setup->tau_count, error);
}

static bool refuse_long_cluster(const option_t *option, const char *text, void *place,
                                sim_error_t *error)
{
    (void)option;
    (void)text;
    (void)place;
    return sim_fail(error,
                    "--long-cluster: removed; use --longest-tau to see slow changes of the noise");
}

bool setup_read_base(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    setup_t *const setup = place;
    const unsigned long value = strtoul(text, NULL, 16);
    const size_t prefix = ((text[0] == '0') && ((text[1] == 'x') || (text[1] == 'X'))) ? 2U : 0U;
    const bool digits = (strspn(text + prefix, "0123456789abcdefABCDEF") == strlen(text + prefix));
    setup->can_base = (uint32_t)value;
    setup->frames_only = option->name;
    return (digits && (text[prefix] != '\0') && (value <= DAVAR_CAN_LAST_ID)) ||
           sim_fail(error, "--%s: a hexadecimal identifier up to 7F0 expected, found '%s'",
                    option->name, text);
}

bool setup_read_content(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    static const uint32_t CONTENT[] = {
        0U, DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS,
        DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS | DAVAR_SEND_INTERVALS, DAVAR_SEND_FD};
    setup_t *const setup = place;
    unsigned choice = 0;
    const bool good = read_choice(option, text, &choice, error);
    setup->can_content = CONTENT[choice];
    setup->frames_only = option->name;
    return good;
}

bool setup_read_raw(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    setup_t *const setup = place;
    setup->frames_only = option->name;
    return read_flag(option, text, &setup->raw, error);
}

static option_read_t read_law;

const option_t setup_law[] = {
    {.help = "Window, in samples"},
    {"law", "fixed|kurtosis|or|and|glr", read_law, AT(law),
     "rule for the window length (default or: kurtosis OR\n"
     "contribution; glr: a likelihood ratio test starts the window\n"
     "where the noise changed)"},
    {"policy", "", read_law, AT(law), NULL}, /* in older scripts */
    {"long-cluster", "N", refuse_long_cluster, 0, NULL},
    {0},
};

static bool read_law(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    (void)option;
    return read_choice(&setup_law[1], text, place, error);
}

const option_t setup_window[] = {
    {"window-max", "N", read_count, AT(window_max),
     "longest window (default 600; glr: 600 blocks)"},
    {"window-min", "N", read_count, AT(window_min),
     "shortest window (default 2/3 of the longest; glr: 2 blocks)"},
    {"segment", "N", read_count, AT(segment),
     "short segment of the contribution test (default 1/6 of the\n"
     "longest window; glr: 0)"},
    {"kurtosis", "K1:K2", read_range, AT(kurtosis),
     "stable range of the kurtosis (default 2.5:3.3)"},
    {"contribution", "S1:S2", read_range, AT(contribution),
     "stable range of the sliding kurtosis contribution (default\n"
     "0:0.07)"},
    {"unstable-rate", "X", read_unstable_rate, AT(unstable_rate),
     "instead of both ranges: the share of windows of unchanged noise\n"
     "that may be unstable, 0.0001 to 0.1. It counts for every length\n"
     "of the window and for the filter of --bandwidth"},
    {"grow", "N, --shrink N", read_count, AT(grow),
     "change of the length per sample (default 2; trailing windows\n"
     "grow by 1; glr shrinks by at least 64)"},
    {"shrink", "N", read_count, AT(shrink), NULL}, /* in the help of --grow */
    {"taus", "octave|geometric[:N]|N,N,...", read_taus, 0,
     "cluster sizes (default octave; geometric: 12)"},
    {0},
};

const option_t setup_glr[] = {
    {.help = "Only for --law glr"},
    {"false-alarms-per-hour", "X", read_positive, AT(false_alarms_per_hour),
     "accepted false alarms per hour of unchanged noise (default\n"
     "0.01)"},
    {"cut-interval", "S", read_positive, AT(cut_interval_s),
     "accepted mean time between false cuts of the window, in seconds\n"
     "(default 300)"},
    {"block", "N", read_count, AT(block), "samples per block (default 10)"},
    {"shock-blocks", "N", read_count, AT(shock_blocks), "longest shock, in blocks (default 2)"},
    {0},
};
