/* davar port template - reads a buffer in two halves; sending is for you to add. */
#include "template_port.h"

static davar_port_read_t read_half(void *context, davar_port_block_t *block)
{
    template_port_t *const state = context;
    const uint32_t waiting = state->filled - state->read;
    if (waiting == 0U) {
        return DAVAR_PORT_READ_AGAIN;
    }
    state->read += waiting;
    state->samples.q15 = state->counts[(state->read - 1U) % 2U];
    *block = (davar_port_block_t){.samples = &state->samples,
                                  .count = TEMPLATE_PORT_HALF,
                                  .missing = (waiting - 1U) * TEMPLATE_PORT_HALF};
    return DAVAR_PORT_READ_BLOCK;
}

/* Here: send the result on the line, or queue it, and return DAVAR_PORT_SEND_DONE.
 * davar_encoder_begin and davar_encoder_next (davar/can.h) convert it to CAN frames, and
 * davar_slcan_encode (davar/slcan.h) converts those to text for a UART. */
static davar_port_send_t send_result(void *context, size_t channel, const davar_result_t *result)
{
    (void)context;
    (void)channel;
    (void)result;
    return DAVAR_PORT_SEND_AGAIN;
}

void template_port_half_done(template_port_t *state)
{
    state->filled = state->filled + 1U;
}

davar_port_t template_port(template_port_t *state)
{
    *state = (template_port_t){.filled = 0U};
    /* Here: start the transfer into state->counts. */
    const davar_port_t port = {.context = state, .read = read_half, .send = send_result};
    return port;
}
