/* davar-node - the Linux gateway: data-ready edge -> count -> library -> packets -> CAN, serial
 * line or UDP, and an alarm pin. */
#include "alarm.h"
#include "davar/fit.h"
#include "davar/glr.h"
#include "davar/torn.h"
#include "davar_node.h"
#include "gpio.h"
#include "outbox.h"
#include "settings.h"
#include "source.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define POLL_MS 20
#define FAREWELL_MS 500U
#define WHY_BYTES 512U

typedef struct {
    node_settings_t settings;
    source_t source;
    gpio_edges_t *edges;
    gpio_output_t *pin;
    alarm_level_t alarm;
    outbox_t outbox;
    davar_encoder_t encoder;     /* of davar's own frames */
    davar_telemetry_t telemetry; /* or of a dialect */
    davar_t davar;
    davar_cascade_t cascade;
    davar_plan_t plan;
    davar_node_channel_t channel;
    davar_node_t node;
    davar_glr_report_t report; /* with the newest result */
    davar_floor_t floor;       /* with --floor, as what follows */
    davar_floor_result_t newest_floor;
    davar_can_health_t health;
    int32_t count;
    davar_port_samples_t samples;
    uint64_t index; /* of the next sample */
    uint32_t owed;  /* samples missing before the next good one */
    davar_torn_t torn;
    int32_t tested;        /* the count that the filter of torn reads delivered */
    uint32_t owed_waiting; /* samples missing before the count that waits in it */
    void *memory;
} gateway_t;

static volatile sig_atomic_t stopped;

static void stop(int signal)
{
    (void)signal;
    stopped = 1;
}

static void count(gateway_t *gateway, davar_health_item_t item, uint32_t by)
{
    uint32_t *counter = &gateway->health.count[item];
    *counter = (by < UINT32_MAX - *counter) ? *counter + by : UINT32_MAX;
}

/* Waits for one data-ready edge. Returns true immediately without a data-ready line. A lost edge
 * skips its line of a recorded file. */
static bool wait_edge(gateway_t *gateway)
{
    uint32_t lost = 0;
    int32_t skipped = 0;
    if (gateway->edges == NULL) {
        return true;
    }
    const gpio_read_t answer = gpio_edges_read(gateway->edges, &lost);
    if (answer != GPIO_EDGE) {
        return false;
    }
    count(gateway, DAVAR_HEALTH_EDGES_LOST, lost);
    gateway->owed += lost;
    for (uint32_t i = 0; (i < lost) && !gateway->source.is_value; i++) {
        count(gateway, DAVAR_HEALTH_SOURCE_FAULTS,
              (source_read(&gateway->source, &skipped) == SOURCE_FAULT) ? 1U : 0U);
    }
    return true;
}

/* Sends the count to the link if --raw is given. */
static void send_raw(gateway_t *gateway)
{
    davar_frame_t frame;
    gateway->index += gateway->owed;
    if (gateway->settings.setup.raw &&
        davar_encoder_raw(&gateway->encoder, gateway->index, gateway->count, &frame)) {
        outbox_put(&gateway->outbox, &frame);
        outbox_flush(&gateway->outbox);
    }
    gateway->index++;
}

static void push_floor(gateway_t *gateway, int32_t count, bool is_gap)
{
    if (is_gap) {
        davar_floor_gap(&gateway->floor);
    }
    if (davar_floor_push(&gateway->floor, &gateway->settings.floor_plan, count)) {
        davar_floor_take(&gateway->floor, &gateway->settings.floor_plan, &gateway->newest_floor);
    }
}

static davar_port_read_t hand_out(gateway_t *gateway, const int32_t *count, uint32_t missing,
                                  davar_port_block_t *block)
{
    if (gateway->settings.floor) {
        push_floor(gateway, *count, missing > 0U);
    }
    gateway->samples.q31 = count;
    *block = (davar_port_block_t){.samples = &gateway->samples, .count = 1U, .missing = missing};
    return DAVAR_PORT_READ_BLOCK;
}

/* The count before the newest one, unless it is torn: that is one missing sample. */
static davar_port_read_t hand_out_tested(gateway_t *gateway, davar_port_block_t *block)
{
    const uint32_t missing = gateway->owed_waiting;
    bool ready = (gateway->owed > 0U) && davar_torn_gap(&gateway->torn, &gateway->tested);
    gateway->owed_waiting = gateway->owed;
    switch (davar_torn_push(&gateway->torn, gateway->count, &gateway->tested)) {
    case DAVAR_TORN_SAMPLE:
        ready = true;
        break;
    case DAVAR_TORN_READ:
        gateway->owed_waiting += missing + 1U;
        break;
    case DAVAR_TORN_NOTHING:
    default:
        break;
    }
    return ready ? hand_out(gateway, &gateway->tested, missing, block) : DAVAR_PORT_READ_AGAIN;
}

static davar_port_read_t take_sample(gateway_t *gateway, davar_port_block_t *block)
{
    send_raw(gateway);
    const davar_port_read_t answer = gateway->settings.setup.skips_torn
                                         ? hand_out_tested(gateway, block)
                                         : hand_out(gateway, &gateway->count, gateway->owed, block);
    gateway->owed = 0;
    return answer;
}

/* The count that waits, then the end. */
static davar_port_read_t end(gateway_t *gateway, davar_port_block_t *block)
{
    return davar_torn_gap(&gateway->torn, &gateway->tested)
               ? hand_out(gateway, &gateway->tested, gateway->owed_waiting, block)
               : DAVAR_PORT_READ_END;
}

static davar_port_read_t read_sample(void *context, davar_port_block_t *block)
{
    gateway_t *gateway = context;
    if (stopped != 0) {
        return end(gateway, block);
    }
    if (!wait_edge(gateway)) {
        return DAVAR_PORT_READ_AGAIN;
    }
    switch (source_read(&gateway->source, &gateway->count)) {
    case SOURCE_SAMPLE:
        return take_sample(gateway, block);
    case SOURCE_END:
        return end(gateway, block);
    case SOURCE_FAULT:
        gateway->owed++;
        count(gateway, DAVAR_HEALTH_SOURCE_FAULTS, 1U);
        return DAVAR_PORT_READ_FAULT;
    case SOURCE_AGAIN: /* with an edge, this sample is lost: the source was not ready */
    default:
        gateway->owed += (gateway->edges != NULL) ? 1U : 0U;
        count(gateway, DAVAR_HEALTH_SOURCE_FAULTS, (gateway->edges != NULL) ? 1U : 0U);
        return DAVAR_PORT_READ_AGAIN;
    }
}

static void take_health(gateway_t *gateway)
{
    const davar_health_t health = davar_health(&gateway->davar);
    davar_can_health(&gateway->health, &health);
    davar_link_health(gateway->outbox.link, &gateway->health);
}

static void update_alarm(gateway_t *gateway, const davar_result_t *result)
{
    davar_glr_report(&gateway->davar, &gateway->report);
    const bool before = gateway->alarm.high;
    const bool tracks = (gateway->settings.setup.law == DAVAR_LAW_ID_GLR);
    const bool now = alarm_step(&gateway->alarm, result->epoch,
                                tracks ? gateway->report.alarm : result->unstable);
    if (now && !before) {
        count(gateway, DAVAR_HEALTH_ALARMS, 1U);
    }
    if ((gateway->pin != NULL) && (now != before)) {
        (void)gpio_output_set(gateway->pin, now);
    }
}

/* Time since boot. */
static uint64_t now_us(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_nsec / 1000U;
}

static davar_port_send_t send_result(void *context, size_t channel, const davar_result_t *result)
{
    gateway_t *gateway = context;
    const davar_floor_result_t *const floor =
        gateway->settings.floor ? &gateway->newest_floor : NULL;
    (void)channel;
    update_alarm(gateway, result);
    take_health(gateway);
    if (gateway->settings.dialect != NULL) {
        davar_telemetry_floor(&gateway->telemetry, floor);
        davar_telemetry_begin(&gateway->telemetry, result, &gateway->report, now_us());
        outbox_put_telemetry(&gateway->outbox, &gateway->telemetry);
    } else {
        davar_encoder_floor(&gateway->encoder, floor);
        davar_encoder_begin(&gateway->encoder, result, &gateway->report, &gateway->health);
        outbox_put_all(&gateway->outbox, &gateway->encoder);
    }
    outbox_flush(&gateway->outbox);
    return DAVAR_PORT_SEND_DONE;
}

static bool open_pins(gateway_t *gateway, sim_error_t *error)
{
    const node_settings_t *const settings = &gateway->settings;
    const uint64_t period_ns = (uint64_t)(1e9 / settings->config.rate_hz);
    char why[WHY_BYTES] = "";
    gateway->alarm.on_samples = (uint64_t)(settings->alarm_on_s * settings->config.rate_hz);
    gateway->alarm.off_samples = (uint64_t)(settings->alarm_off_s * settings->config.rate_hz);
    if (settings->edges != NULL) {
        gateway->edges = gpio_edges_open(settings->edges, period_ns, why, sizeof why);
        if (gateway->edges == NULL) {
            return sim_fail(error, "--edges: %s", why);
        }
    }
    if (settings->alarm != NULL) {
        gateway->pin = gpio_output_open(settings->alarm, why, sizeof why);
    }
    return (settings->alarm == NULL) || (gateway->pin != NULL) ||
           sim_fail(error, "--alarm: %s", why);
}

static bool start_encoder(gateway_t *gateway, sim_error_t *error)
{
    const node_settings_t *const settings = &gateway->settings;
    const setup_t *const setup = &settings->setup;
    if (settings->dialect != NULL) { /* settings_parse has checked the address */
        return davar_telemetry_init(&gateway->telemetry, settings->dialect, &settings->address,
                                    settings->config.rate_hz);
    }
    if (!davar_encoder_init(&gateway->encoder, &settings->config, (uint16_t)setup->can_base,
                            (uint8_t)settings->channel,
                            (uint8_t)(setup->can_content | (setup->raw ? DAVAR_SEND_RAW : 0U)))) {
        return sim_fail(error, "--base: channel %u does not fit into 11-bit identifiers",
                        settings->channel);
    }
    davar_encoder_session(&gateway->encoder, davar_link_session());
    return true;
}

static bool open_link(gateway_t *gateway, sim_error_t *error)
{
    const node_settings_t *const settings = &gateway->settings;
    const davar_link_options_t wanted = {.where = settings->out,
                                         .fd = (settings->setup.can_content & DAVAR_SEND_FD) != 0U,
                                         .baud = settings->setup.baud,
                                         .wait = settings->wait};
    char why[WHY_BYTES] = "";
    if (!start_encoder(gateway, error)) {
        return false;
    }
    gateway->outbox.link = davar_link_open(&wanted, why, sizeof why);
    if (gateway->outbox.link == NULL) {
        return sim_fail(error, "--out: %s", why);
    }
    const char *const name = davar_link_name(gateway->outbox.link);
    if (strstr(settings->out, name) == NULL) { /* a pty, which has got its name now */
        (void)fprintf(stderr, "davar-node: %.*s on %s\n",
                      (int)(strlen(settings->out) - strlen(":pty")), settings->out, name);
    }
    return true;
}

static bool start_library(gateway_t *gateway, sim_error_t *error)
{
    const node_settings_t *const settings = &gateway->settings;
    const davar_curve_t *const curve = &settings->curve;
    const size_t bytes = davar_memory_size_q31(&settings->config);
    const size_t own_bytes = (bytes + 7U) & ~(size_t)7U;
    const size_t cascade_bytes = davar_curve_bytes(curve, DAVAR_PORT_Q31);
    char *const memory = calloc(1U, own_bytes + cascade_bytes);
    gateway->memory = memory;
    const davar_status_t status =
        (memory == NULL) ? DAVAR_ERR_MEMORY_SIZE
                         : davar_init_q31(&gateway->davar, &settings->config, memory, bytes);
    if (status != DAVAR_OK) {
        return setup_fail(status, false, error);
    }
    davar_cascade_status_t cascade = DAVAR_CASCADE_OK;
    if (cascade_bytes > 0U) {
        gateway->channel.cascade = &gateway->cascade;
        cascade = davar_curve_start(curve, DAVAR_PORT_Q31, &gateway->cascade, memory + own_bytes,
                                    cascade_bytes);
    }
    davar_curve_plan(curve, &gateway->plan,
                     (settings->setup.filter[0] != '\0') ? &settings->filter : NULL);
    return (cascade == DAVAR_CASCADE_OK) ||
           sim_fail(error, "--longest-tau: %s", davar_cascade_status_text(cascade));
}

static bool start(gateway_t *gateway, sim_error_t *error)
{
    if (!source_open(&gateway->source, gateway->settings.source)) {
        return sim_fail(error, "--source: %s: %s", gateway->settings.source, strerror(errno));
    }
    davar_torn_init(&gateway->torn);
    davar_floor_start(&gateway->floor);
    davar_floor_take(&gateway->floor, &gateway->settings.floor_plan, &gateway->newest_floor);
    gateway->channel = (davar_node_channel_t){
        .davar = &gateway->davar, .number = DAVAR_PORT_Q31, .plan = &gateway->plan};
    return start_library(gateway, error) && open_pins(gateway, error) && open_link(gateway, error);
}

/* Sends what is due, and keeps the link alive. */
static void tend(gateway_t *gateway)
{
    davar_packet_t heartbeat;
    if ((gateway->settings.dialect != NULL) &&
        davar_telemetry_heartbeat(&gateway->telemetry, now_us(), &heartbeat)) {
        outbox_put_packet(&gateway->outbox, &heartbeat);
    }
    outbox_flush(&gateway->outbox);
    davar_link_poll(gateway->outbox.link);
}

/* Sleeps until an edge or a line is available, or a short time has passed. */
static void rest(gateway_t *gateway)
{
    struct pollfd one = {.fd = gateway->source.descriptor, .events = POLLIN};
    if (gateway->edges != NULL) {
        one.fd = gpio_edges_descriptor(gateway->edges);
    }
    tend(gateway);
    (void)poll(&one, 1, (gateway->outbox.count > 0U) ? 1 : POLL_MS);
}

/* Sends every counter once more, as many as the link accepts in half a second. */
static void farewell(gateway_t *gateway)
{
    davar_frame_t rest;
    take_health(gateway);
    if (gateway->settings.dialect == NULL) {
        if (davar_encoder_raw_rest(&gateway->encoder, &rest)) {
            outbox_put(&gateway->outbox, &rest);
        }
        davar_encoder_finish(&gateway->encoder, &gateway->health);
        outbox_put_all(&gateway->outbox, &gateway->encoder);
    }
    for (uint32_t ms = 0; (gateway->outbox.count > 0U) && (ms < FAREWELL_MS); ms++) {
        outbox_flush(&gateway->outbox);
        davar_link_wait(gateway->outbox.link, 1U);
    }
    outbox_drop(&gateway->outbox);
    if (gateway->pin != NULL) {
        (void)gpio_output_set(gateway->pin, false);
    }
}

static void run(gateway_t *gateway)
{
    const davar_port_t port = {.context = gateway, .read = read_sample, .send = send_result};
    davar_node_init(&gateway->node, &gateway->channel, 1U, &port);
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    uint32_t steps = 0;
    while (state != DAVAR_NODE_DONE) {
        state = davar_node_step(&gateway->node);
        if (state == DAVAR_NODE_IDLE) {
            rest(gateway);
        }
        steps++;
        if (steps % 64U == 0U) {
            tend(gateway);
        }
    }
    farewell(gateway);
}

static void report(const gateway_t *gateway)
{
    static const char *const names[DAVAR_HEALTH_COUNT] = {
        "gaps",           "missing samples", "saturated samples",
        "not finite",     "window restarts", "results missed",
        "frames dropped", "send retries",    "error passive",
        "bus off",        "link lost",       "link restored",
        "noise bytes",    "edges lost",      "source faults",
        "alarms",         "window cuts",     "noise alarms",
        "shocks excluded"};
    (void)fprintf(stderr, "davar-node: %llu samples, %llu results",
                  (unsigned long long)gateway->node.counters.samples,
                  (unsigned long long)gateway->node.counters.results);
    for (size_t item = 0; item < DAVAR_HEALTH_COUNT; item++) {
        if (gateway->health.count[item] > 0U) {
            (void)fprintf(stderr, ", %u %s", gateway->health.count[item], names[item]);
        }
    }
    if (davar_torn_reads(&gateway->torn) > 0U) {
        (void)fprintf(stderr, ", %u torn register reads", davar_torn_reads(&gateway->torn));
    }
    (void)fputc('\n', stderr);
}

static void finish(gateway_t *gateway)
{
    if (gateway->source.descriptor > 0) {
        source_close(&gateway->source);
    }
    davar_link_close(gateway->outbox.link);
    gpio_edges_close(gateway->edges);
    gpio_output_close(gateway->pin);
    free(gateway->memory);
    free(gateway);
}

static int work(gateway_t *gateway, int argc, char **argv)
{
    sim_error_t error = {{0}};
    const command_status_t status = settings_parse(&gateway->settings, argc, argv, &error);
    const bool good = (status == COMMAND_RUN) ? start(gateway, &error)
                                              : command_show(&settings_command, status, &error);
    if (!good) {
        (void)fprintf(stderr, "davar-node: %s\n", error.text);
        return 2;
    }
    if (status != COMMAND_RUN) {
        return 0;
    }
    run(gateway);
    take_health(gateway);
    report(gateway);
    return 0;
}

int main(int argc, char **argv)
{
    const struct sigaction action = {.sa_handler = stop};
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    gateway_t *gateway = calloc(1U, sizeof *gateway);
    if (gateway == NULL) {
        (void)fprintf(stderr, "davar-node: %s\n", strerror(ENOMEM));
        return 2;
    }
    const int status = work(gateway, argc, argv);
    finish(gateway);
    return status;
}
