/* davar-sim - pass 2 with centred windows. All channels have the same windows and gaps, so the same
 * sample completes an epoch of each. */
#include "replay/host.h"

#include "davar/fit.h"

/* Fits and sends the result that waits in a channel. */
static bool send_result(const davar_port_t *port, engine_t *engine, size_t c)
{
    static davar_result_t result;
    const davar_node_channel_t *const channel = &engine->channels[c];
    if (!centred_take(engine->centred[c], &result)) {
        return true;
    }
    if (channel->cascade != NULL) {
        (void)davar_cascade_append(channel->cascade, &result);
    }
    davar_fit(channel->plan, engine->config.rate_hz, &result);
    (void)davar_fit_flat(channel->plan, engine->config.rate_hz, &result);
    return port->send(port->context, c, &result) == DAVAR_PORT_SEND_DONE;
}

/* Pushes up to the next epoch, or to the end of the block. Returns how many samples. */
static size_t push_some(engine_t *engine, size_t c, const davar_port_block_t *block, size_t from)
{
    const size_t taken = centred_push(engine->centred[c], block->samples[c], from, block->count);
    if (engine->channels[c].cascade != NULL) {
        davar_curve_push(engine->channels[c].cascade, engine->number, block->samples[c], from,
                         taken);
    }
    return taken;
}

static bool take_block(const davar_port_t *port, engine_t *engine, const davar_port_block_t *block)
{
    for (size_t c = 0; (c < engine->count) && (block->missing > 0U); c++) {
        engine_gap(engine, c, block->missing);
    }
    for (size_t done = 0; done < block->count;) {
        size_t taken = 0;
        for (size_t c = 0; c < engine->count; c++) {
            taken = push_some(engine, c, block, done);
            if (!send_result(port, engine, c)) {
                return false;
            }
        }
        done += taken;
    }
    return true;
}

static bool flush_all(const davar_port_t *port, engine_t *engine)
{
    bool is_more = true;
    for (size_t c = 0; c < engine->count; c++) {
        if (engine->channels[c].cascade != NULL) {
            davar_cascade_flush(engine->channels[c].cascade);
        }
    }
    while (is_more) {
        is_more = false;
        for (size_t c = 0; c < engine->count; c++) {
            is_more = centred_flush(engine->centred[c]) || is_more;
            if (!send_result(port, engine, c)) {
                return false;
            }
        }
    }
    return true;
}

bool host_replay(replay_t *replay, engine_t *engine)
{
    const davar_port_t port = replay_port(replay);
    davar_port_read_t state = DAVAR_PORT_READ_AGAIN;
    while ((state == DAVAR_PORT_READ_AGAIN) || (state == DAVAR_PORT_READ_BLOCK)) {
        davar_port_block_t block = {0};
        state = port.read(port.context, &block);
        if (state == DAVAR_PORT_READ_AGAIN) {
            replay_wait(replay);
        } else if ((state == DAVAR_PORT_READ_BLOCK) && !take_block(&port, engine, &block)) {
            return false;
        }
    }
    return (state == DAVAR_PORT_READ_END) && flush_all(&port, engine);
}
