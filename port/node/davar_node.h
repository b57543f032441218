/** @file
 * davar - the node loop: read -> push -> take -> fit -> send.
 *
 * It connects the library to the hardware. It has no heap, no I/O and no clock. The port contract
 * (davar_port.h) provides I/O and the clock. */
#ifndef DAVAR_NODE_H
#define DAVAR_NODE_H

#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/** One signal: an instance that the davar_init_* of its number type has started. All channels of a
 * node have the same configuration, so their results have the same epochs. */
typedef struct {
    davar_t *davar;             /**< the instance; it must outlive the node */
    davar_port_number_t number; /**< number type of that instance */
    /** a cascade that davar_cascade_init_* of the same type has started: the node pushes the same
     * samples to it, and its cluster sizes follow those of the window in every result. They end at
     * the newest sample that was pushed, in centred mode too. Null: none */
    davar_cascade_t *cascade;
    /** plan of the fit, for the taus of the configuration and of the cascade; channels with equal
     * taus may share one. Null: ADEV only */
    davar_plan_t *plan;
    /** @privatesection */
    size_t position; /* processed samples of the current block (after the end: flushed results) */
} davar_node_channel_t;

/** Counters of the node. Saturating. */
typedef struct {
    uint32_t blocks;          /**< blocks read */
    uint64_t samples;         /**< samples read, per channel */
    uint64_t results;         /**< results sent, over all channels */
    uint32_t send_retries;    /**< times send returned "try again" */
    uint32_t send_faults;     /**< results lost because send failed */
    uint32_t read_faults;     /**< times read failed */
    uint32_t longest_step_us; /**< longest davar_node_step; 0 without a clock */
} davar_node_counters_t;

/** The outcome of a step. */
typedef enum {
    /** read or send failed (counted, reported to the port); more steps are allowed */
    DAVAR_NODE_FAULT = -1,
    /** nothing now: no sample is available, or no room to send; sleep if you like, then step
     * again */
    DAVAR_NODE_IDLE = 0,
    DAVAR_NODE_RUNNING, /**< did some work, and there may be more: step again */
    /** the stream has ended and every result has been sent; further steps change nothing */
    DAVAR_NODE_DONE
} davar_node_state_t;

/** The node. Fields are private except `counters`. Stores the one result that waits for the bus. */
typedef struct {
    /** @privatesection */
    const davar_port_t *port;
    davar_node_channel_t *channels;
    size_t channel_count;
    /** @publicsection */
    davar_node_counters_t counters; /**< what has happened since davar_node_init */
    /** @privatesection */
    davar_port_block_t block;
    size_t pending_channel;
    bool pending; /* `result` of `pending_channel` must still be sent */
    bool ended;   /* read returned its end; the flush follows */
    davar_result_t result;
} davar_node_t;

/** Connects `count` (>= 1) started channels to a port. Channels and port belong to the caller and
 * must outlive the node. Null pointers, no channel, or a port without read or send are caller bugs
 * (asserted). Cost: O(count). */
void davar_node_init(davar_node_t *node, davar_node_channel_t *channels, size_t count,
                     const davar_port_t *port);

/** Does one bounded piece of work. It sends the waiting result again; or pushes one channel up to
 * its next result (or the end of its block) and sends that result; or reads one block; or flushes
 * one result after the end. Never waits. Results are sent epoch by epoch, and the channels of an
 * epoch in order. No result is lost if send returns "try again". Call it from one thread. Cost:
 * davar_push_* of at most one block, one davar_take and davar_fit, O(channels). */
davar_node_state_t davar_node_step(davar_node_t *node);

#ifdef __cplusplus
}
#endif

#endif
