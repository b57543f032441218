/* davar - the node loop. One rule keeps channels in step: the channel that is furthest behind is
 * next, and of equal ones the lower one. */
#include "davar_node.h"
#include "davar/fit.h"

#include <assert.h>

static void count_one(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        (*counter)++;
    }
}

static uint32_t now_us(const davar_port_t *port)
{
    return (port->now_us != NULL) ? port->now_us(port->context) : 0U;
}

static davar_node_state_t fault(const davar_port_t *port, davar_port_fault_t what,
                                uint32_t *counter)
{
    count_one(counter);
    if (port->fault != NULL) {
        port->fault(port->context, what);
    }
    return DAVAR_NODE_FAULT;
}

/* Starts every channel at the beginning of a block of `count` samples. */
static void rewind_channels(davar_node_t *node, size_t count)
{
    node->block.count = count;
    for (size_t c = 0; c < node->channel_count; c++) {
        node->channels[c].position = 0;
    }
}

static void lose(const davar_node_channel_t *channel, uint32_t missing)
{
    davar_gap(channel->davar, missing);
    if (channel->cascade != NULL) {
        davar_cascade_gap(channel->cascade, missing);
    }
}

static davar_node_state_t begin_block(davar_node_t *node, const davar_port_block_t *block)
{
    assert((block->samples != NULL) && (block->count > 0U));
    node->block = *block;
    rewind_channels(node, block->count);
    if (node->block.missing > 0U) {
        for (size_t c = 0; c < node->channel_count; c++) {
            lose(&node->channels[c], node->block.missing);
        }
    }
    count_one(&node->counters.blocks);
    node->counters.samples += node->block.count;
    return DAVAR_NODE_RUNNING;
}

/* The flush is treated as a block without end. Each flushed result counts as one "sample" of it. */
static davar_node_state_t begin_flush(davar_node_t *node)
{
    node->ended = true;
    for (size_t c = 0; c < node->channel_count; c++) {
        if (node->channels[c].cascade != NULL) {
            davar_cascade_flush(node->channels[c].cascade);
        }
    }
    rewind_channels(node, SIZE_MAX);
    return DAVAR_NODE_RUNNING;
}

static davar_node_state_t read_block(davar_node_t *node)
{
    davar_node_state_t state = DAVAR_NODE_IDLE;
    davar_port_block_t block = {0};
    switch (node->port->read(node->port->context, &block)) {
    case DAVAR_PORT_READ_BLOCK:
        state = begin_block(node, &block);
        break;
    case DAVAR_PORT_READ_END:
        state = begin_flush(node);
        break;
    case DAVAR_PORT_READ_FAULT:
        state = fault(node->port, DAVAR_PORT_FAULT_READ, &node->counters.read_faults);
        break;
    case DAVAR_PORT_READ_AGAIN:
    default:
        break;
    }
    return state;
}

/* The next channel to process; channel_count if all have finished the block. */
static size_t furthest_behind(const davar_node_t *node)
{
    size_t behind = node->channel_count;
    size_t least = node->block.count;
    for (size_t c = 0; c < node->channel_count; c++) {
        if (node->channels[c].position < least) {
            least = node->channels[c].position;
            behind = c;
        }
    }
    return behind;
}

static size_t push(davar_node_channel_t *channel, const davar_port_samples_t *samples, size_t count)
{
    size_t consumed = 0;
    switch (channel->number) {
    case DAVAR_PORT_Q15:
        consumed =
            davar_push_until_result_q15(channel->davar, samples->q15 + channel->position, count);
        break;
    case DAVAR_PORT_Q31:
        consumed =
            davar_push_until_result_q31(channel->davar, samples->q31 + channel->position, count);
        break;
    case DAVAR_PORT_F32:
    default:
        consumed =
            davar_push_until_result_f32(channel->davar, samples->f32 + channel->position, count);
        break;
    }
    return consumed;
}

static void push_cascade(const davar_node_channel_t *channel, const davar_port_samples_t *samples,
                         size_t count)
{
    switch (channel->number) {
    case DAVAR_PORT_Q15:
        davar_cascade_push_q15(channel->cascade, samples->q15 + channel->position, count);
        break;
    case DAVAR_PORT_Q31:
        davar_cascade_push_q31(channel->cascade, samples->q31 + channel->position, count);
        break;
    case DAVAR_PORT_F32:
    default:
        davar_cascade_push_f32(channel->cascade, samples->f32 + channel->position, count);
        break;
    }
}

static void push_rest(davar_node_t *node, size_t c)
{
    davar_node_channel_t *channel = &node->channels[c];
    const davar_port_samples_t *const samples = &node->block.samples[c];
    const size_t consumed = push(channel, samples, node->block.count - channel->position);
    if (channel->cascade != NULL) {
        push_cascade(channel, samples, consumed);
    }
    channel->position += consumed;
}

static void flush_one(davar_node_t *node, size_t c)
{
    davar_node_channel_t *channel = &node->channels[c];
    channel->position = davar_flush(channel->davar) ? channel->position + 1U : SIZE_MAX;
}

static davar_node_state_t send_pending(davar_node_t *node)
{
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    switch (node->port->send(node->port->context, node->pending_channel, &node->result)) {
    case DAVAR_PORT_SEND_DONE:
        node->pending = false;
        node->counters.results++;
        break;
    case DAVAR_PORT_SEND_FAULT:
        node->pending = false;
        state = fault(node->port, DAVAR_PORT_FAULT_SEND, &node->counters.send_faults);
        break;
    case DAVAR_PORT_SEND_AGAIN:
    default:
        count_one(&node->counters.send_retries);
        state = DAVAR_NODE_IDLE;
        break;
    }
    return state;
}

static davar_node_state_t serve(davar_node_t *node, size_t c)
{
    const davar_node_channel_t *const channel = &node->channels[c];
    if (node->ended) {
        flush_one(node, c);
    } else {
        push_rest(node, c);
    }
    node->pending = davar_take(channel->davar, &node->result);
    node->pending_channel = c;
    if (node->pending && (channel->cascade != NULL)) {
        (void)davar_cascade_append(channel->cascade, &node->result);
    }
    if (node->pending && (channel->plan != NULL)) {
        davar_fit(channel->plan, channel->davar->config->rate_hz, &node->result);
        (void)davar_fit_flat(channel->plan, channel->davar->config->rate_hz, &node->result);
    }
    return node->pending ? send_pending(node) : DAVAR_NODE_RUNNING;
}

static davar_node_state_t advance(davar_node_t *node)
{
    if (node->pending) {
        return send_pending(node);
    }
    const size_t c = furthest_behind(node);
    if (c < node->channel_count) {
        return serve(node, c);
    }
    return node->ended ? DAVAR_NODE_DONE : read_block(node);
}

void davar_node_init(davar_node_t *node, davar_node_channel_t *channels, size_t count,
                     const davar_port_t *port)
{
    assert((node != NULL) && (channels != NULL) && (count > 0U));
    assert((port != NULL) && (port->read != NULL) && (port->send != NULL));
    *node = (davar_node_t){.port = port, .channels = channels, .channel_count = count};
    rewind_channels(node, 0);
}

davar_node_state_t davar_node_step(davar_node_t *node)
{
    assert((node != NULL) && (node->port != NULL));
    const uint32_t start_us = now_us(node->port);
    const davar_node_state_t state = advance(node);
    const uint32_t elapsed_us = now_us(node->port) - start_us;
    if (elapsed_us > node->counters.longest_step_us) {
        node->counters.longest_step_us = elapsed_us;
    }
    return state;
}
