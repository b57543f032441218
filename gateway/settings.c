/* davar-node - command line. */
#include "settings.h"

#include <string.h>

#define ALARM_S_MAX 1e6
#define CHANNEL_LAST 34U /* of 11-bit identifiers */
#define STRIDE_USUAL 100U

#define AT(member) offsetof(node_settings_t, member)

static bool read_filter(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    setup_t *const setup = place;
    (void)option;
    return setup_read_filter(setup, text, "", error);
}

static bool read_bits(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    const uint32_t *const bits = place;
    return read_whole(option, text, place, error) &&
           (((*bits >= 2U) && (*bits <= 32U)) ||
            sim_fail(error, "--bits: 2 to 32 expected, found '%s'", text));
}

static bool read_alarm_s(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    const double *const seconds = place;
    return read_real(option, text, place, error) &&
           (((*seconds >= 0.0) && (*seconds <= ALARM_S_MAX)) ||
            sim_fail(error, "--%s: 0 to %g s expected, found '%s'", option->name, ALARM_S_MAX,
                     text));
}

static bool refuse_word(void *values, const option_t *last, const char *word, sim_error_t *error)
{
    (void)values;
    (void)last;
    return sim_fail(error, "unexpected argument '%s' (see --help)", word);
}

static const char BEFORE[] =
    "usage: davar-node --source SRC --rate HZ --lsb DPS --out LINK [options]\n"
    "\n"
    "Reads the counts of one gyro axis, computes their dynamic Allan variance and sends the\n"
    "results to a CAN bus, a serial line or an autopilot (addons/can/DESIGN.md, "
    "docs/DIALECTS.md).\n"
    "One process handles one channel. For more axes start one davar-node each, with\n"
    "--channel 0, 1, 2.\n";

static const option_t SOURCE[] = {
    {.help = "Source"},
    {"source", "SRC", read_text, AT(source),
     "'-', a file or a FIFO with one count per line, or value:PATH, a\n"
     "file that is read again for each sample (an IIO\n"
     "in_anglvel_x_raw; needs --edges). Lines may begin with notes (#)\n"
     "and one header. After them, a line that is not a whole number\n"
     "counts as a source fault and as a lost sample, which makes a gap"},
    {"edges", "CHIP:LINE", read_text, AT(edges),
     "read one sample per rising edge of a data-ready line. A lost edge\n"
     "is a lost sample: it makes a gap, and its line of a recorded file\n"
     "is skipped"},
    {"rate", "HZ", read_positive, AT(setup.rate_hz), "sample rate"},
    {"lsb", "DPS", read_positive, AT(setup.lsb), "size of a count in deg/s"},
    {"bandwidth", "FILTER", read_filter, 0,
     "what the gyro's noise passes: HZ[:ORDER[:PERCENT]] (analogue, of\n"
     "1 or 2 poles, default 2, known to PERCENT, default 10), biquad:HZ,\n"
     "pt1:HZ, notch:HZ:Q, average:N, cic[ORDER]:N, sum:N,\n"
     "ba:B0,B1,..[:A1,A2,..], or several with + between them; or none\n"
     "(default: unknown; results that the filter could falsify are then\n"
     "withheld)"},
    {"bits", "N", read_bits, AT(bits), "width of a count, 2 to 32 (default 24)"},
    {"skip-torn-reads", NULL, read_flag, AT(setup.skips_torn),
     "skip torn register reads: single counts that jump by a power of\n"
     "two and back. Each is a lost sample. Samples arrive one later"},
    {0},
};

static const option_t RESULTS[] = {
    {"longest-tau", "S", read_positive, AT(setup.longest_tau_s),
     "further octaves of cluster sizes, up to S seconds, beyond the\n"
     "window"},
    {"stride", "K", read_count, AT(setup.stride),
     "one result every K samples (default 100, or a shorter --window-max)"},
    {"engine", "auto|grid", read_choice, AT(setup.engine),
     "algorithm for strides: equal results, different cost"},
    {"floor", NULL, read_flag, AT(floor),
     "also the noise between rotor lines and motion (docs/FLIGHT.md), in\n"
     "can:, slcan: and mavlink:. It needs --bandwidth, and --bits to see\n"
     "clipped counts of fewer than 24 bits"},
    {0},
};

static const option_t OUTPUT[] = {
    {.help = "Output"},
    {"out", "LINK", read_text, AT(out),
     "can:IFACE or slcan:PATH (a tty): davar's own frames\n"
     "mavlink:udp:HOST:PORT or mavlink:serial:PATH (a tty): MAVLink 2\n"
     "dronecan:IFACE: DroneCAN\n"
     "cyphal:IFACE: Cyphal, on an interface with CAN FD\n"
     "With the PATH pty it creates a pty and prints its name"},
    {"node-id", "N", read_count, AT(node_id),
     "component in MAVLink (default 191 + channel), node in DroneCAN\n"
     "and Cyphal (default 100 + channel). Each process needs its own"},
    {"system-id", "N", read_count, AT(system_id), "system in MAVLink (default 1)"},
    {"subject-id", "N", read_count, AT(subject_id), "subject in Cyphal (default 3700)"},
    {"baud", "N", read_whole, AT(setup.baud), "baud rate of the serial line (default: unchanged)"},
    {"channel", "N", read_whole, AT(channel), "channel of this process (default 0)"},
    {"wait", NULL, read_flag, AT(wait),
     "start even if the interface or tty does not exist yet, or the\n"
     "network is down. The name of a HOST is resolved once, at the start"},
    {.help = "Only for can: and slcan:"},
    {"content", "summary|full|intervals|fd", setup_read_content, 0,
     "\n"
     "frames of a result: 6 frames, all values (default), also limits,\n"
     "one CAN FD frame"},
    {"raw", NULL, setup_read_raw, 0,
     "also send frames of the counts, for davarlab live --raw (bus load:\n"
     "addons/can/DESIGN.md)"},
    {"base", "HEX", setup_read_base, 0, "CAN identifier of channel 0 (default 5D0)"},
    {.help = "Alarm"},
    {"alarm", "CHIP:LINE", read_text, AT(alarm),
     "output line that is high while the noise is unstable; glr: for\n"
     "--alarm-off seconds after a change"},
    {"alarm-on", "S", read_alarm_s, AT(alarm_on_s),
     "seconds of unstable noise before the line rises (default 0)"},
    {"alarm-off", "S", read_alarm_s, AT(alarm_off_s),
     "seconds of stable noise before the line falls (default 1)"},
    {0},
};

static const char AFTER[] =
    "\n"
    "If the link is lost, davar-node waits for it to return. DAVAR_Health and the last line on\n"
    "standard error count frames that could not be sent. The program ends at the end of the\n"
    "source or on SIGINT or SIGTERM. On can: and slcan: it then sends every counter once more.\n"
    "Exit status: 0 done, 2 bad option or source.\n";

static const option_t *const LISTS[] = {SOURCE,    setup_law, setup_window, RESULTS,
                                        setup_glr, OUTPUT,    NULL};

const command_t settings_command = {.name = "davar-node",
                                    .before = BEFORE,
                                    .after = AFTER,
                                    .lists = LISTS,
                                    .read_word = refuse_word};

/* An option that not every kind of output has. */
static bool check_kind(const node_settings_t *settings, sim_error_t *error)
{
    const davar_dialect_t *const dialect = settings->dialect;
    const char *const frames_only = settings->setup.frames_only;
    const struct {
        const char *option;
        bool given;
        bool allowed;
        const char *outputs;
    } options[] = {
        {frames_only, frames_only != NULL, dialect == NULL, "can:IFACE or slcan:PATH"},
        {"node-id", settings->node_id.given, dialect != NULL,
         "mavlink:.., dronecan:IFACE or cyphal:IFACE"},
        {"system-id", settings->system_id.given, dialect == &davar_mavlink, "mavlink:.."},
        {"floor", settings->floor, (dialect == NULL) || (dialect == &davar_mavlink),
         "can:IFACE, slcan:PATH or mavlink:.."},
        {"subject-id", settings->subject_id.given, dialect == &davar_cyphal, "cyphal:IFACE"}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (options[i].given && !options[i].allowed) {
            return sim_fail(error, "--%s: needs --out %s", options[i].option, options[i].outputs);
        }
    }
    return true;
}

static bool in_range(const char *option, uint32_t value, uint32_t least, uint32_t most,
                     sim_error_t *error)
{
    return ((value >= least) && (value <= most)) ||
           sim_fail(error, "--%s: %u to %u expected, found %u", option, least, most, value);
}

/* Sets the parts of the address that were given. */
static bool fill_address(node_settings_t *settings, sim_error_t *error)
{
    davar_telemetry_address_t *const address = &settings->address;
    const bool is_mavlink = (settings->dialect == &davar_mavlink);
    const uint32_t node = settings->node_id.given ? settings->node_id.value : address->node;
    const uint32_t system = settings->system_id.given ? settings->system_id.value : address->system;
    const uint32_t subject =
        settings->subject_id.given ? settings->subject_id.value : address->subject;
    address->node = (uint8_t)node;
    address->system = (uint8_t)system;
    address->subject = (uint16_t)subject;
    return in_range("channel", settings->channel, 0U, DAVAR_TELEMETRY_CHANNEL_LAST, error) &&
           in_range("node-id", node, 1U, is_mavlink ? 255U : 127U, error) &&
           in_range("system-id", system, 1U, 255U, error) &&
           in_range("subject-id", subject, 0U, 8191U, error);
}

/* Chooses between davar's own frames and a dialect. */
static bool fill_output(node_settings_t *settings, sim_error_t *error)
{
    settings->dialect =
        davar_link_dialect(settings->out, (uint8_t)settings->channel, &settings->address);
    return check_kind(settings, error) &&
           ((settings->dialect != NULL)
                ? fill_address(settings, error)
                : in_range("channel", settings->channel, 0U, CHANNEL_LAST, error));
}

static bool check(const node_settings_t *settings, sim_error_t *error)
{
    if ((settings->source == NULL) || (settings->out == NULL)) {
        return sim_fail(error, "--%s: required (see --help)",
                        (settings->source == NULL) ? "source" : "out");
    }
    if ((strncmp(settings->source, "value:", 6) == 0) && (settings->edges == NULL)) {
        return sim_fail(error, "--source: value:PATH needs --edges, which sets the sample times");
    }
    if ((settings->alarm_on_s > 0.0) && (settings->setup.law == DAVAR_LAW_ID_GLR)) {
        return sim_fail(
            error,
            "--alarm-on: cannot be used with --law glr, because its alarms have no duration");
    }
    if (!(settings->setup.rate_hz > 0.0) || !(settings->setup.lsb > 0.0)) {
        return sim_fail(error, "--%s: required (see --help)",
                        (settings->setup.rate_hz > 0.0) ? "lsb" : "rate");
    }
    return true;
}

static bool configure(node_settings_t *settings, sim_error_t *error)
{
    davar_config_t *const config = &settings->config;
    const setup_t *const setup = &settings->setup;
    if (!setup_configure(setup, config, settings->taus, error)) {
        return false;
    }
    config->sample_bits = (uint8_t)settings->bits;
    if (!setup->stride.given) {
        config->stride =
            (config->window.longest < STRIDE_USUAL) ? config->window.longest : STRIDE_USUAL;
    }
    const bool declares = (setup->filter[0] != '\0');
    if (!setup_check(config, false, error) ||
        (declares && !setup_filter(setup, config->rate_hz, &settings->filter, error))) {
        return false;
    }
    const davar_filter_t *const filter = declares ? &settings->filter : NULL;
    setup_adapt(setup, config, filter);
    return (!settings->floor || setup_floor(config, DAVAR_PORT_Q31, filter, settings->source,
                                            &settings->floor_plan, error)) &&
           setup_curve(setup, config, DAVAR_PORT_Q31, &settings->curve, error);
}

command_status_t settings_parse(node_settings_t *settings, int argc, char **argv,
                                sim_error_t *error)
{
    *settings = (node_settings_t){.setup = SETUP_USUAL, .alarm_off_s = 1.0, .bits = 24U};
    const command_status_t status = command_read(&settings_command, settings, argc, argv, error);
    const bool good =
        (status != COMMAND_RUN) ||
        (check(settings, error) && fill_output(settings, error) && configure(settings, error));
    return good ? status : COMMAND_BAD;
}
