/* davar - the node loop: read -> push -> take -> fit -> send, the only joint between the library and the world.
 * No heap, no I/O, no clock of its own: all of that is behind the port contract (davar_port.h). */
#ifndef DAVAR_NODE_H
#define DAVAR_NODE_H

#include "davar/davar.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One signal: an instance started with the davar_init_* of its number type. All channels of a node are started with the
 * same configuration, so that their results come in step. */
typedef struct {
    davar_t *davar;
    davar_port_number_t number;
    davar_plan_t *
        plan; /* of the fit, for the taus of the configuration; channels with the same may share one. Null: ADEV only */
    size_t
        position; /* private: samples of the current block (after the end: flushed results) already done */
} davar_node_channel_t;

/* What the node did and met. Saturating. */
typedef struct {
    uint32_t blocks;          /* blocks read */
    uint64_t samples;         /* samples read, per channel */
    uint64_t results;         /* results sent, all channels together */
    uint32_t send_retries;    /* times send said "try again" */
    uint32_t send_faults;     /* results lost because send failed */
    uint32_t read_faults;     /* times read failed */
    uint32_t longest_step_us; /* longest davar_node_step; 0 without a clock */
} davar_node_counters_t;

/* What a step found. */
typedef enum {
    DAVAR_NODE_FAULT =
        -1, /* read or send failed (counted, reported to the port); stepping on is allowed */
    DAVAR_NODE_IDLE =
        0, /* nothing now: no sample waits, or no room to send; sleep if you like, then step again */
    DAVAR_NODE_RUNNING, /* did some work, there may be more: step again */
    DAVAR_NODE_DONE /* the stream ended and every result has been sent; further steps change nothing */
} davar_node_state_t;

/* The node. Fields are private but for `counters`. Holds the one result that waits for the bus. */
typedef struct {
    const davar_port_t *port;
    davar_node_channel_t *channels;
    size_t channel_count;
    davar_node_counters_t counters;
    davar_port_block_t block;
    size_t pending_channel;
    bool pending; /* `result` of `pending_channel` still has to be sent */
    bool ended;   /* read said so; what follows is the flush */
    davar_result_t result;
} davar_node_t;

/* Joins `count` (>= 1) started channels to a port. Channels and port belong to the caller and must outlive the node.
 * Null pointers, no channel, or a port without read or send are caller bugs (asserted). O(count). */
void davar_node_init(davar_node_t *node, davar_node_channel_t *channels, size_t count,
                     const davar_port_t *port);

/* One bounded piece of work: retry the waiting result, or push one channel up to its next result (or the end of its
 * block) and send that result, or read one block, or flush one result after the end. Never waits. Results leave epoch by
 * epoch, the channels of an epoch in order, and none is lost when send says "try again". Call it from one thread.
 * Cost: davar_push_* of at most one block, one davar_take and davar_fit, O(channels). */
davar_node_state_t davar_node_step(davar_node_t *node);

#ifdef __cplusplus
}
#endif

#endif
