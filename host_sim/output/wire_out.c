/* davar-sim - sends frames. */
#include "output/wire_out.h"

#include "common/sim_clock.h"
#include "common/stop.h"

#include <stdio.h>
#include <stdlib.h>

#define WAIT_MS 1U
#define STUCK_S 10.0 /* a bus without room for this long is broken */

static bool make_encoders(wire_out_t *wire, const options_t *options, sim_error_t *error)
{
    wire->encoder = calloc(wire->engine->count, sizeof *wire->encoder);
    if (wire->encoder == NULL) {
        return sim_fail(error, "out of memory");
    }
    const uint8_t session = davar_link_session();
    for (size_t c = 0; c < wire->engine->count; c++) {
        const bool fits =
            (c <= UINT8_MAX) &&
            davar_encoder_init(&wire->encoder[c], &wire->engine->config,
                               (uint16_t)options->setup.can_base, (uint8_t)c,
                               (uint8_t)(options->setup.can_content | DAVAR_SEND_MONITOR |
                                         (options->setup.raw ? DAVAR_SEND_RAW : 0U)));
        if (!fits) {
            return sim_fail(
                error,
                "--can-base: channel %zu of %zu does not fit into the 11-bit identifiers from 0x%X",
                c, wire->engine->count, options->setup.can_base);
        }
        davar_encoder_session(&wire->encoder[c], session);
    }
    return true;
}

/* Encoders of the link's dialect. */
static bool make_telemetry(wire_out_t *wire, const options_t *options, sim_error_t *error)
{
    wire->telemetry = calloc(wire->engine->count, sizeof *wire->telemetry);
    if (wire->telemetry == NULL) {
        return sim_fail(error, "out of memory");
    }
    for (size_t c = 0; c < wire->engine->count; c++) {
        davar_telemetry_address_t address;
        const uint8_t channel = (uint8_t)((c <= UINT8_MAX) ? c : UINT8_MAX);
        const davar_dialect_t *dialect = davar_link_dialect(options->link, channel, &address);
        if (!davar_telemetry_init(&wire->telemetry[c], dialect, &address,
                                  wire->engine->config.rate_hz)) {
            return sim_fail(error, "--out: %s: more than %u columns", options->link,
                            DAVAR_TELEMETRY_CHANNEL_LAST + 1U);
        }
    }
    return true;
}

bool wire_out_open(wire_out_t *wire, const options_t *options, const engine_t *engine,
                   sim_error_t *error)
{
    char why[512];
    const davar_link_options_t wanted = {.where = options->link,
                                         .fd = (options->setup.can_content & DAVAR_SEND_FD) != 0U,
                                         .baud = options->setup.baud};
    *wire = (wire_out_t){.engine = engine};
    davar_telemetry_address_t address;
    const bool is_dialect = (davar_link_dialect(options->link, 0U, &address) != NULL);
    if (!(is_dialect ? make_telemetry(wire, options, error)
                     : make_encoders(wire, options, error))) {
        return false;
    }
    wire->link = davar_link_open(&wanted, why, sizeof why);
    if (wire->link == NULL) {
        return sim_fail(error, "--out: %s", why);
    }
    if (!davar_link_is_up(wire->link)) {
        (void)fprintf(stderr, "davar-sim: %s on %s: waiting for a reader\n",
                      is_dialect ? "mavlink" : "slcan", davar_link_name(wire->link));
    }
    return true;
}

/* True while it makes sense to wait: indefinitely for a reader, at most STUCK_S for a bus. */
static bool wait_for_room(const wire_out_t *wire, double since_s)
{
    const bool no_reader_yet = !davar_link_is_up(wire->link);
    davar_link_wait(wire->link, WAIT_MS);
    return no_reader_yet || (sim_clock_s() - since_s < STUCK_S);
}

static bool send_packet(const wire_out_t *wire, const davar_packet_t *packet, sim_error_t *error)
{
    double since_s = sim_clock_s();
    for (;;) {
        const davar_port_send_t answer = davar_link_send(wire->link, packet);
        if (answer == DAVAR_PORT_SEND_DONE) {
            return true;
        }
        if (answer == DAVAR_PORT_SEND_FAULT) {
            return sim_fail(error, "--out: %s: the link is lost", davar_link_name(wire->link));
        }
        if (stop_requested(error)) {
            return false;
        }
        since_s = davar_link_is_up(wire->link) ? since_s : sim_clock_s();
        if (!wait_for_room(wire, since_s)) {
            return sim_fail(
                error, "--out: %s: no room for %g s; check that another node acknowledges frames",
                davar_link_name(wire->link), STUCK_S);
        }
    }
}

static bool send_frame(const wire_out_t *wire, const davar_frame_t *frame, sim_error_t *error)
{
    const davar_packet_t packet = davar_link_packet(frame);
    return send_packet(wire, &packet, error);
}

static void take_health(wire_out_t *wire, size_t channel)
{
    const davar_health_t health = engine_health_of(wire->engine, channel);
    davar_link_poll(wire->link);
    davar_link_health(wire->link, &wire->health);
    davar_can_health(&wire->health, &health);
}

static bool send_all(wire_out_t *wire, size_t channel, sim_error_t *error)
{
    davar_frame_t frame;
    while (davar_encoder_next(&wire->encoder[channel], &frame)) {
        if (!send_frame(wire, &frame, error)) {
            return false;
        }
    }
    return true;
}

/* Their time is that of the recording. */
static bool send_telemetry(wire_out_t *wire, size_t channel, const epoch_row_t *row,
                           sim_error_t *error)
{
    davar_telemetry_t *telemetry = &wire->telemetry[channel];
    davar_packet_t packet;
    const double time_us = 1e6 * (double)row->result->epoch / wire->engine->config.rate_hz;
    if (davar_telemetry_heartbeat(telemetry, (uint64_t)time_us, &packet) &&
        !send_packet(wire, &packet, error)) {
        return false;
    }
    davar_telemetry_floor(telemetry, row->floor);
    davar_telemetry_begin(telemetry, row->result, row->report, (uint64_t)time_us);
    while (davar_telemetry_next(telemetry, &packet)) {
        if (!send_packet(wire, &packet, error)) {
            return false;
        }
    }
    return true;
}

bool wire_out_result(wire_out_t *wire, size_t channel, const epoch_row_t *row, sim_error_t *error)
{
    take_health(wire, channel);
    if (wire->telemetry != NULL) {
        return send_telemetry(wire, channel, row, error);
    }
    davar_encoder_monitor(&wire->encoder[channel], row->misfit);
    davar_encoder_floor(&wire->encoder[channel], row->floor);
    davar_encoder_begin(&wire->encoder[channel], row->result, row->report, &wire->health);
    return send_all(wire, channel, error);
}

static bool encode_raw(davar_encoder_t *encoder, const raw_run_t *run, size_t channel, size_t i,
                       davar_frame_t *frame)
{
    const davar_port_samples_t *samples = &run->samples[channel];
    const uint64_t index = run->first + i;
    if (run->number == DAVAR_PORT_F32) {
        davar_encoder_raw_f32(encoder, index, samples->f32[i], frame);
        return true;
    }
    const int32_t count = (run->number == DAVAR_PORT_Q15) ? samples->q15[i] : samples->q31[i];
    return davar_encoder_raw(encoder, index, count, frame);
}

bool wire_out_raw(wire_out_t *wire, const raw_run_t *run, sim_error_t *error)
{
    davar_frame_t frame;
    for (size_t i = 0; i < run->count; i++) {
        for (size_t c = 0; c < wire->engine->count; c++) {
            if (encode_raw(&wire->encoder[c], run, c, i, &frame) &&
                !send_frame(wire, &frame, error)) {
                return false;
            }
        }
    }
    return true;
}

bool wire_out_finish(wire_out_t *wire, sim_error_t *error)
{
    for (size_t c = 0; (c < wire->engine->count) && (wire->telemetry == NULL); c++) {
        davar_frame_t rest;
        take_health(wire, c);
        if (davar_encoder_raw_rest(&wire->encoder[c], &rest) && !send_frame(wire, &rest, error)) {
            return false;
        }
        davar_encoder_finish(&wire->encoder[c], &wire->health);
        if (!send_all(wire, c, error)) {
            return false;
        }
    }
    return true;
}

void wire_out_close(wire_out_t *wire)
{
    davar_link_close(wire->link);
    free(wire->encoder);
    free(wire->telemetry);
    *wire = (wire_out_t){0};
}
