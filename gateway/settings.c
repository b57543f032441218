/* davar-node - command line. */
#include "settings.h"

#include "davar/can.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ALARM_S_MAX 1e6
#define NOT_GIVEN UINT32_MAX /* no option has this value */

static const char *const HELP[] = {
    "usage: davar-node --source SRC --rate HZ --lsb DPS --out LINK [options]\n"
    "\n"
    "Reads the counts of one gyro axis, computes their dynamic Allan variance and sends the\n"
    "results to a CAN bus, a serial line or an autopilot (addons/can/DESIGN.md, "
    "docs/DIALECTS.md).\n"
    "One process handles one channel. For more axes start one davar-node each, with\n"
    "--channel 0, 1, 2.\n"
    "\n"
    "Source\n"
    "  --source SRC      '-', a file or a FIFO with one count per line, or value:PATH, a file\n"
    "                    that is read again for each sample (an IIO in_anglvel_x_raw; needs\n"
    "                    --edges). Lines may begin with notes (#) and one header. After them, a\n"
    "                    line that is not a whole number counts as a source fault and as a lost\n"
    "                    sample, which makes a gap\n"
    "  --edges CHIP:LINE  read one sample per rising edge of a data-ready line. A lost edge is\n"
    "                    a lost sample: it makes a gap, and its line of a recorded file is\n"
    "                    skipped\n"
    "  --rate HZ         sample rate\n"
    "  --lsb DPS         size of a count in deg/s\n"
    "  --bandwidth FILTER  what the gyro's noise passes: HZ[:ORDER[:PERCENT]] (a low-pass of 1\n"
    "                    or 2 poles, default 2, known to PERCENT, default 10), average:N,\n"
    "                    cic[ORDER]:N, sum:N, HZ+average:N or none (default: unknown; results\n"
    "                    that the filter could falsify are then withheld)\n"
    "  --bits N          width of a count, 2 to 32 (default 24)\n"
    "  --skip-torn-reads  skip torn register reads: single counts that jump by a power of two\n"
    "                    and back. Each is a lost sample. Samples arrive one later\n"
    "\n"
    "Window, in samples\n"
    "  --law or|glr      rule for the window length: the paper's law (default), or a likelihood\n"
    "                    ratio test that detects changes of the noise (docs/FIRMWARE.md)\n"
    "  --window-max N    longest window (default 600; glr: 6000)\n"
    "  --window-min N    shortest window (default 400; glr: 20)\n"
    "  --segment N       short segment of the contribution test (default 100; glr: 0)\n"
    "  --stride K        one result every K samples (default 100)\n"
    "  --longest-tau S   further octaves of cluster sizes, up to S seconds, beyond the window\n"
    "  --false-alarms-per-hour X  glr: accepted false alarms per hour of unchanged noise\n"
    "                    (default 0.01)\n"
    "  --cut-interval S  glr: accepted mean time between false cuts of the window, in seconds\n"
    "                    (default 300)\n"
    "\n",

    "Output\n"
    "  --out LINK        can:IFACE or slcan:PATH (a tty): davar's own frames\n"
    "                    mavlink:udp:HOST:PORT or mavlink:serial:PATH (a tty): MAVLink 2\n"
    "                    dronecan:IFACE: DroneCAN\n"
    "                    cyphal:IFACE: Cyphal, on an interface with CAN FD\n"
    "                    With the PATH pty it creates a pty and prints its name\n"
    "  --node-id N       component in MAVLink (default 191 + channel), node in DroneCAN and\n"
    "                    Cyphal (default 100 + channel). Each process needs its own\n"
    "  --system-id N     system in MAVLink (default 1)\n"
    "  --subject-id N    subject in Cyphal (default 3700)\n"
    "  --baud N          baud rate of the serial line (default: unchanged)\n"
    "  --channel N       channel of this process (default 0)\n"
    "  --wait            start even if the interface or tty does not exist yet, or the network is\n"
    "                    down. The name of a HOST is resolved once, at the start\n"
    "\n"
    "Only for can: and slcan:\n"
    "  --content WHAT    frames of a result: summary, full (default), intervals or fd\n"
    "  --raw             also send frames of the counts, for davarlab live --raw (bus load:\n"
    "                    addons/can/DESIGN.md)\n"
    "  --base HEX        CAN identifier of channel 0 (default 5D0)\n"
    "\n"
    "Alarm\n"
    "  --alarm CHIP:LINE  output line that is high while the noise is unstable; glr: for\n"
    "                    --alarm-off seconds after a change\n"
    "  --alarm-on S      seconds of unstable noise before the line rises (default 0)\n"
    "  --alarm-off S     seconds of stable noise before the line falls (default 1)\n"
    "  --help\n"
    "\n"
    "If the link is lost, davar-node waits for it to return. DAVAR_Health and the last line on\n"
    "standard error count frames that could not be sent. The program ends at the end of the\n"
    "source or on SIGINT or SIGTERM. On can: and slcan: it then sends every counter once more.\n"
    "Exit status: 0 done, 2 bad option or source.\n",
};

void settings_help(void)
{
    for (size_t i = 0; i < sizeof HELP / sizeof HELP[0]; i++) {
        (void)fputs(HELP[i], stdout);
    }
}

typedef enum { TEXT, REAL, WHOLE, HEX, FLAG, CONTENT, LAW, FILTER, REMOVED } kind_t;

typedef struct {
    const char *name;
    kind_t kind;
    size_t offset;
} entry_t;

#define AT(member) offsetof(node_settings_t, member)

/* sample_bits is a byte and is checked separately. */
static const entry_t TABLE[] = {
    {"source", TEXT, AT(source)},
    {"out", TEXT, AT(out)},
    {"edges", TEXT, AT(edges)},
    {"alarm", TEXT, AT(alarm)},
    {"rate", REAL, AT(config.rate_hz)},
    {"lsb", REAL, AT(config.unit_per_count)},
    {"alarm-on", REAL, AT(alarm_on_s)},
    {"alarm-off", REAL, AT(alarm_off_s)},
    {"bandwidth", FILTER, 0},
    {"law", LAW, AT(config.law)},
    {"policy", LAW, AT(config.law)}, /* in older scripts */
    {"false-alarms-per-hour", REAL, AT(config.glr.false_alarms_per_hour)},
    {"cut-interval", REAL, AT(config.glr.cut_interval_s)},
    {"long-cluster", REMOVED, 0},
    {"window-max", WHOLE, AT(config.window.longest)},
    {"window-min", WHOLE, AT(config.window.shortest)},
    {"segment", WHOLE, AT(config.moments.segment)},
    {"stride", WHOLE, AT(config.stride)},
    {"longest-tau", REAL, AT(longest_tau_s)},
    {"channel", WHOLE, AT(channel)},
    {"baud", WHOLE, AT(baud)},
    {"base", HEX, AT(base)},
    {"content", CONTENT, AT(content)},
    {"node-id", WHOLE, AT(node_id)},
    {"system-id", WHOLE, AT(system_id)},
    {"subject-id", WHOLE, AT(subject_id)},
    {"bits", WHOLE, 0},
    {"raw", FLAG, AT(raw)},
    {"skip-torn-reads", FLAG, AT(skips_torn)},
    {"wait", FLAG, AT(wait)},
    {"help", FLAG, AT(help)},
};
#define ENTRIES (sizeof TABLE / sizeof TABLE[0])

static bool set_content(node_settings_t *settings, const char *text)
{
    static const char *const WORDS[] = {"summary", "full", "intervals", "fd"};
    static const uint32_t CONTENT_BITS[] = {
        0U, DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS,
        DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS | DAVAR_SEND_INTERVALS, DAVAR_SEND_FD};
    for (size_t i = 0; i < 4U; i++) {
        if (strcmp(text, WORDS[i]) == 0) {
            settings->content = CONTENT_BITS[i];
            return true;
        }
    }
    return false;
}

static bool set_law(node_settings_t *settings, const char *text)
{
    const bool tracks = (strcmp(text, "glr") == 0);
    settings->config.law = tracks ? &davar_law_glr_q31 : &davar_law_or;
    return tracks || (strcmp(text, "or") == 0);
}

static bool set_number(node_settings_t *settings, const entry_t *entry, const char *text)
{
    char *end = NULL;
    void *where = (char *)settings + entry->offset;
    if (entry->kind == REAL) {
        const double value = strtod(text, &end);
        memcpy(where, &value, sizeof value);
        return (end != text) && (*end == '\0') && isfinite(value) && (value >= 0.0);
    }
    const unsigned long long value = strtoull(text, &end, (entry->kind == HEX) ? 16 : 10);
    const uint32_t small = (uint32_t)value;
    if ((end == text) || (*end != '\0') || (strchr(text, '-') != NULL) || (value >= NOT_GIVEN)) {
        return false;
    }
    if (strcmp(entry->name, "bits") == 0) {
        settings->config.sample_bits = (uint8_t)((small <= 32U) ? small : 0U);
        return (small >= 2U) && (small <= 32U);
    }
    memcpy(where, &small, sizeof small);
    return true;
}

static bool apply(node_settings_t *settings, const entry_t *entry, const char *text)
{
    switch (entry->kind) {
    case TEXT:
        memcpy((char *)settings + entry->offset, &text, sizeof text);
        return true;
    case FLAG:
        *((bool *)((char *)settings + entry->offset)) = true;
        return true;
    case CONTENT:
        return set_content(settings, text);
    case LAW:
        return set_law(settings, text);
    case FILTER:
        settings->declares_filter = davar_bandwidth_read(text, &settings->bandwidth);
        return settings->declares_filter;
    case REMOVED:
        return false;
    case REAL:
    case WHOLE:
    case HEX:
    default:
        return set_number(settings, entry, text);
    }
}

static const char *expected(const entry_t *entry)
{
    static const char *const WORDS[] = {[REAL] = "a number of at least 0",
                                        [WHOLE] = "a whole number of at least 0",
                                        [HEX] = "a hexadecimal number",
                                        [CONTENT] = "summary, full, intervals or fd",
                                        [LAW] = "or or glr"};
    if (entry->kind == FILTER) {
        return DAVAR_BANDWIDTH_FORMS;
    }
    return (strcmp(entry->name, "bits") == 0) ? "2 to 32" : WORDS[entry->kind];
}

static void complain(const entry_t *entry, const char *text, char *why, size_t size)
{
    if (entry->kind == REMOVED) {
        (void)snprintf(why, size,
                       "--%s: removed; use --longest-tau to see slow changes of the noise",
                       entry->name);
        return;
    }
    (void)snprintf(why, size, "--%s: %s expected, found '%s'", entry->name, expected(entry), text);
}

static bool walk(node_settings_t *settings, int argc, char **argv, char *why, size_t size)
{
    struct option options[ENTRIES + 1U] = {{0}};
    int found = 0;
    for (size_t i = 0; i < ENTRIES; i++) {
        options[i] = (struct option){TABLE[i].name,
                                     (TABLE[i].kind == FLAG) ? no_argument : required_argument,
                                     NULL, (int)(i + 256U)};
    }
    opterr = 0;
    while ((found = getopt_long(argc, argv, ":", options, NULL)) != -1) {
        if (found < 256) {
            (void)snprintf(why, size, "%s '%s' (see --help)",
                           (found == ':') ? "no value for" : "unknown option", argv[optind - 1]);
            return false;
        }
        const entry_t *entry = &TABLE[found - 256];
        if (!apply(settings, entry, optarg)) {
            complain(entry, optarg, why, size);
            return false;
        }
    }
    if (optind < argc) {
        (void)snprintf(why, size, "unexpected argument '%s' (see --help)", argv[optind]);
        return false;
    }
    return true;
}

/* Sets the defaults of options that were not given: the window lengths of the paper, or for glr a
 * minute at 100 Hz that can shrink to two blocks. */
static void fill_window(davar_config_t *config)
{
    const bool tracks = (config->law == &davar_law_glr_q31);
    const davar_config_t *usual = &davar_default_config;
    if (config->window.longest == NOT_GIVEN) {
        config->window.longest = tracks ? (600U * config->glr.block) : usual->window.longest;
    }
    if (config->window.shortest == NOT_GIVEN) {
        config->window.shortest = tracks ? (2U * config->glr.block) : usual->window.shortest;
    }
    if (config->stride == NOT_GIVEN) {
        config->stride = (config->window.longest < 100U) ? config->window.longest : 100U;
    }
    if (config->moments.segment == NOT_GIVEN) {
        config->moments.segment = tracks ? 0U : usual->moments.segment;
    }
}

/* An option that not every kind of output has. */
static bool check_kind(const node_settings_t *settings, char *why, size_t size)
{
    static const char *const own = "can:IFACE or slcan:PATH";
    static const char *const any = "mavlink:.., dronecan:IFACE or cyphal:IFACE";
    const davar_dialect_t *dialect = settings->dialect;
    const struct {
        const char *option;
        bool given;
        bool allowed;
        const char *outputs;
    } options[] = {
        {"raw", settings->raw, dialect == NULL, own},
        {"base", settings->base != NOT_GIVEN, dialect == NULL, own},
        {"content", settings->content != NOT_GIVEN, dialect == NULL, own},
        {"node-id", settings->node_id != NOT_GIVEN, dialect != NULL, any},
        {"system-id", settings->system_id != NOT_GIVEN, dialect == &davar_mavlink, "mavlink:.."},
        {"subject-id", settings->subject_id != NOT_GIVEN, dialect == &davar_cyphal,
         "cyphal:IFACE"}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (options[i].given && !options[i].allowed) {
            (void)snprintf(why, size, "--%s: needs --out %s", options[i].option,
                           options[i].outputs);
            return false;
        }
    }
    return true;
}

/* Sets what was not given, and checks what was. */
static bool fill_address(node_settings_t *settings, char *why, size_t size)
{
    davar_telemetry_address_t *address = &settings->address;
    const uint32_t channel = settings->channel;
    const struct {
        const char *option;
        uint32_t *value;
        uint32_t usual;
        uint32_t least;
        uint32_t most;
    } options[] = {{"channel", &settings->channel, channel, 0U, DAVAR_TELEMETRY_CHANNEL_LAST},
                   {"node-id", &settings->node_id, address->node, 1U,
                    (settings->dialect == &davar_mavlink) ? 255U : 127U},
                   {"system-id", &settings->system_id, address->system, 1U, 255U},
                   {"subject-id", &settings->subject_id, address->subject, 0U, 8191U}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        uint32_t *value = options[i].value;
        *value = (*value == NOT_GIVEN) ? options[i].usual : *value;
        if ((*value < options[i].least) || (*value > options[i].most)) {
            (void)snprintf(why, size, "--%s: %u to %u expected, found %u", options[i].option,
                           options[i].least, options[i].most, *value);
            return false;
        }
    }
    address->node = (uint8_t)settings->node_id;
    address->system = (uint8_t)settings->system_id;
    address->subject = (uint16_t)settings->subject_id;
    return true;
}

/* Chooses between davar's own frames and a dialect. */
static bool fill_output(node_settings_t *settings, char *why, size_t size)
{
    settings->dialect =
        davar_link_dialect(settings->out, (uint8_t)settings->channel, &settings->address);
    if (!check_kind(settings, why, size)) {
        return false;
    }
    if (settings->dialect != NULL) {
        settings->content = 0U;
        return fill_address(settings, why, size);
    }
    settings->base = (settings->base == NOT_GIVEN) ? DAVAR_CAN_BASE : settings->base;
    settings->content = (settings->content == NOT_GIVEN)
                            ? (DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS)
                            : settings->content;
    if ((settings->base > DAVAR_CAN_LAST_ID) || (settings->channel > 34U)) {
        (void)snprintf(why, size, "--%s: exceeds the 11-bit identifiers",
                       (settings->channel > 34U) ? "channel" : "base");
        return false;
    }
    return true;
}

static bool check(node_settings_t *settings, char *why, size_t size)
{
    const char *missing =
        (settings->source == NULL) ? "source" : ((settings->out == NULL) ? "out" : NULL);
    if (missing != NULL) {
        (void)snprintf(why, size, "--%s: required (see --help)", missing);
        return false;
    }
    if ((strncmp(settings->source, "value:", 6) == 0) && (settings->edges == NULL)) {
        (void)snprintf(why, size,
                       "--source: value:PATH needs --edges, which sets the sample times");
        return false;
    }
    if ((settings->alarm_on_s > 0.0) && (settings->config.law == &davar_law_glr_q31)) {
        (void)snprintf(
            why, size,
            "--alarm-on: cannot be used with --law glr, because its alarms have no duration");
        return false;
    }
    if ((settings->alarm_on_s > ALARM_S_MAX) || (settings->alarm_off_s > ALARM_S_MAX)) {
        const bool on = settings->alarm_on_s > ALARM_S_MAX;
        (void)snprintf(why, size, "--alarm-%s: more than %g s", on ? "on" : "off", ALARM_S_MAX);
        return false;
    }
    return fill_output(settings, why, size);
}

/* Extends the cluster sizes to --longest-tau. */
static bool extend(node_settings_t *settings, char *why, size_t size)
{
    char reason[256];
    if (settings->longest_tau_s < 0.0) {
        davar_curve_make(&settings->curve, &settings->config, 0U);
        return true;
    }
    if (davar_curve_reach(&settings->curve, &settings->config, DAVAR_PORT_Q31,
                          settings->longest_tau_s, reason, sizeof reason)) {
        return true;
    }
    (void)snprintf(why, size, "--longest-tau: %s", reason);
    return false;
}

/* Converts the filter to the sample rate. */
static bool fits_rate(node_settings_t *settings, char *why, size_t size)
{
    const double rate_hz = settings->config.rate_hz;
    if (davar_bandwidth_at(&settings->bandwidth, rate_hz, &settings->filter)) {
        davar_bandwidth_whiten(&settings->config,
                               settings->declares_filter ? &settings->filter : NULL);
        return true;
    }
    (void)snprintf(why, size,
                   "--bandwidth: expected " DAVAR_BANDWIDTH_RANGE " (here %g Hz), found %g Hz",
                   rate_hz, settings->bandwidth.hz);
    return false;
}

/* The option that caused a status. */
static const char *option_of(davar_status_t status)
{
    static const struct {
        davar_status_t status;
        const char *option;
    } OPTIONS[] = {{DAVAR_ERR_RATE, "--rate"},
                   {DAVAR_ERR_SCALE, "--lsb"},
                   {DAVAR_ERR_WINDOW_MIN, "--window-min"},
                   {DAVAR_ERR_SEGMENT, "--segment"},
                   {DAVAR_ERR_TRACKING, "--law glr"},
                   {DAVAR_ERR_STRIDE, "--stride"},
                   {DAVAR_ERR_STRIDE_LONG, "--stride"}};
    for (size_t i = 0; i < sizeof OPTIONS / sizeof OPTIONS[0]; i++) {
        if (OPTIONS[i].status == status) {
            return OPTIONS[i].option;
        }
    }
    return "--window-max";
}

bool settings_parse(node_settings_t *settings, int argc, char **argv, char *why, size_t size)
{
    *settings = (node_settings_t){.base = NOT_GIVEN,
                                  .alarm_off_s = 1.0,
                                  .longest_tau_s = -1.0,
                                  .content = NOT_GIVEN,
                                  .node_id = NOT_GIVEN,
                                  .system_id = NOT_GIVEN,
                                  .subject_id = NOT_GIVEN,
                                  .config = davar_default_config};
    settings->config.stride = NOT_GIVEN;
    settings->config.window.longest = NOT_GIVEN;
    settings->config.window.shortest = NOT_GIVEN;
    settings->config.moments.segment = NOT_GIVEN;
    const bool read = walk(settings, argc, argv, why, size);
    fill_window(&settings->config);
    if (!read || (!settings->help && !check(settings, why, size))) {
        return false;
    }
    settings->config.taus = settings->taus;
    settings->config.tau_count =
        davar_taus_octave(settings->config.window.longest, settings->taus, DAVAR_TAUS_MAX);
    const davar_status_t status =
        davar_memory_size_q31(&settings->config) > 0U ? DAVAR_OK : DAVAR_ERR_NULL;
    if (settings->help || (status == DAVAR_OK)) {
        return settings->help || (fits_rate(settings, why, size) && extend(settings, why, size));
    }
    davar_t probe;
    uint64_t none[1];
    const davar_status_t cause = davar_init_q31(&probe, &settings->config, none, sizeof none);
    (void)snprintf(why, size, "%s: %s", option_of(cause), davar_status_text(cause));
    return false;
}
