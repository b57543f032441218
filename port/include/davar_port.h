/* davar - the port contract: everything the node loop asks of the world.
 *
 *   world -> read -> [node: push -> take -> fit] -> send -> world
 *
 * A port is one davar_port_t: four functions and the context they share. CSV replay, CAN, serial line, Linux gpio and
 * bare metal implement it; the node loop (port/node) is its only caller; no port knows another. A new port starts here
 * and needs nothing else.
 *
 * Zero means "nothing now, try again". read and send never wait: when there is no sample yet, or no room on the bus,
 * they return 0 at once and the node asks again at its next step. Zero is not an error, is never counted as a fault and
 * must not be used for one: a sensor that has stopped, a bus that is off or a file that ended has a code of its own.
 *
 * Interrupts: the node calls all four functions from one thread of execution (the main loop), never from an interrupt
 * and never one inside another. What the port does in its own interrupts (fill the next buffer, empty a transmit queue)
 * is its own affair; it must not touch the block it has handed out, nor call the node.
 *
 * Ownership: the port owns every sample buffer and its context; the node owns the results. Each side may use what the
 * other handed it only for as long as the function concerned says. */
#ifndef DAVAR_PORT_H
#define DAVAR_PORT_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The number type of a channel: which davar_init_* and davar_push_* belong to it. */
typedef enum {
    DAVAR_PORT_Q15 = 0, /* int16_t counts */
    DAVAR_PORT_Q31,     /* int32_t counts */
    DAVAR_PORT_F32      /* float, unit of the rate (deg/s) */
} davar_port_number_t;

/* The samples of one channel; the member in use is the one of the channel's number type. */
typedef union {
    const int16_t *q15;
    const int32_t *q31;
    const float *f32;
} davar_port_samples_t;

/* A run of samples without a loss in it, for every channel at once: samples[c] points to `count` samples of channel c. */
typedef struct {
    const davar_port_samples_t *samples; /* one entry per channel, in channel order */
    size_t count;                        /* samples per channel, >= 1 */
    uint32_t missing; /* sample periods lost just before the first of them; 0: none */
} davar_port_block_t;

typedef enum {
    DAVAR_PORT_READ_FAULT =
        -1, /* the source failed; the node counts it and asks again if it is stepped again */
    DAVAR_PORT_READ_AGAIN = 0, /* nothing now, try again; *block is untouched */
    DAVAR_PORT_READ_BLOCK = 1, /* *block is filled */
    DAVAR_PORT_READ_END = 2    /* no sample will ever come again; read is not called after this */
} davar_port_read_t;

typedef enum {
    DAVAR_PORT_SEND_FAULT =
        -1, /* this result cannot be delivered, now or later: the node counts it and drops it */
    DAVAR_PORT_SEND_AGAIN =
        0, /* no room now, try again: the node offers the same result at its next step */
    DAVAR_PORT_SEND_DONE = 1 /* delivered, or copied into the port's own queue */
} davar_port_send_t;

/* What is reported through fault(). */
typedef enum {
    DAVAR_PORT_FAULT_READ = 0, /* read returned DAVAR_PORT_READ_FAULT */
    DAVAR_PORT_FAULT_SEND /* send returned DAVAR_PORT_SEND_FAULT; one result of one channel was lost */
} davar_port_fault_t;

/* A port. Must outlive the node that uses it; may live in flash. */
typedef struct {
    void *context; /* passed to every function as it is */

    /* Hands out the next block. The samples stay valid and unchanged until the next call of read; the node does not
     * call again before it has consumed every sample of every channel. Blocks may have any length: one sample from a
     * data-ready interrupt, half a DMA buffer, a page of a file; results do not depend on it. A loss may only sit
     * before a block, so a port that finds one in the middle hands out two blocks. */
    davar_port_read_t (*read)(void *context, davar_port_block_t *block);

    /* Delivers one result of one channel. Called epoch by epoch and, within an epoch, in channel order. *result is
     * valid during the call only: a port that queues must copy. While send answers "try again" the node reads no
     * further sample, so a port whose source cannot wait needs buffers on the read side. */
    davar_port_send_t (*send)(void *context, size_t channel, const davar_result_t *result);

    /* Microseconds on a monotonic clock that may start anywhere and wraps at 2^32: only differences are used. Null: no
     * clock; durations are then reported as 0. */
    uint32_t (*now_us)(void *context);

    /* Tells the port, once per occurrence, what the node counted as a fault: blink, log, restart the bus. Must return
     * and must not call the node. Null: counted only. */
    void (*fault)(void *context, davar_port_fault_t what);
} davar_port_t;

#ifdef __cplusplus
}
#endif

#endif
