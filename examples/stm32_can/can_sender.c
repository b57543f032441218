/* Converts results to frames (addons/can/DESIGN.md) and sends one whenever the controller has room.
 *
 *   main loop:  bxcan_poll / fdcan_poll;  can_sender_step;
 *               davar_take -> davar_fit -> can_sender_result
 *
 * Receivers are available: `tools/davarlab live can:can0`, or any tool that reads
 * tools/davar.dbc. */
#include "can_sender.h"

static davar_encoder_t encoder;
static davar_can_health_t counters;
static davar_result_t result;
static davar_frame_t frame;
static bool holds; /* a frame is waiting for room */
static can_send_t send;
static void *controller;

bool can_sender_start(const davar_config_t *config, uint8_t session, bool fd, can_send_t how,
                      void *with)
{
    if (!davar_encoder_init(&encoder, config, DAVAR_CAN_BASE, 0U,
                            fd ? DAVAR_SEND_FD : (DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS))) {
        return false;
    }
    davar_encoder_session(&encoder, session);
    counters = (davar_can_health_t){{0}};
    holds = false;
    send = how;
    controller = with;
    return true;
}

void can_sender_result(const davar_result_t *newest, const davar_health_t *health, uint32_t bus_off)
{
    for (; holds; holds = davar_encoder_next(&encoder, &frame)) {
        counters.count[DAVAR_HEALTH_FRAMES_DROPPED]++;
    }
    davar_can_health(&counters, health);
    counters.count[DAVAR_HEALTH_BUS_OFF] = bus_off;
    result = *newest;
    davar_encoder_begin(&encoder, &result, NULL, &counters);
    holds = davar_encoder_next(&encoder, &frame);
}

void can_sender_step(void)
{
    if (holds && send(controller, &frame)) {
        holds = davar_encoder_next(&encoder, &frame);
    }
}
