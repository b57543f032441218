/** @file
 * davar - the port contract: the interface between the node loop and the hardware.
 *
 * ```
 * world -> read -> [node: push -> take -> fit] -> send -> world
 * ```
 *
 * A port is one davar_port_t: four functions and the context they share. CSV replay, CAN, serial
 * line, Linux gpio and bare metal implement it. The node loop (port/node) is its only caller. Ports
 * do not know each other. To write a new port, you need only this header.
 *
 * Zero means "nothing now, try again". read and send never wait. If no sample is available, or the
 * bus has no room, they return 0 immediately, and the node calls them again at its next step. Zero
 * is not an error and is never counted as a fault. Do not return it for a fault: a stopped sensor,
 * a bus that is off and the end of a file have their own codes.
 *
 * Interrupts: the node calls all four functions from one thread of execution (the main loop). It
 * never calls them from an interrupt or inside each other. The port may use its own interrupts, for
 * example to fill the next buffer or to empty a transmit queue. They must not touch the block that
 * read returned, and must not call the node.
 *
 * Ownership: the port owns every sample buffer and its context. The node owns the results. The
 * comment of each function states how long the other side may use them. */
#ifndef DAVAR_PORT_H
#define DAVAR_PORT_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The number type of a channel. It selects davar_init_* and davar_push_*. */
typedef enum {
    DAVAR_PORT_Q15 = 0, /**< int16_t counts */
    DAVAR_PORT_Q31,     /**< int32_t counts */
    DAVAR_PORT_F32      /**< float, unit of the rate (deg/s) */
} davar_port_number_t;

/** The samples of one channel. The number type of the channel selects the member. */
typedef union {
    const int16_t *q15; /**< DAVAR_PORT_Q15: counts */
    const int32_t *q31; /**< DAVAR_PORT_Q31: counts */
    const float *f32;   /**< DAVAR_PORT_F32: rates, deg/s */
} davar_port_samples_t;

/** Samples of all channels without a loss between them: samples[c] points to `count` samples of
 * channel c. */
typedef struct {
    const davar_port_samples_t *samples; /**< one entry per channel, in channel order */
    size_t count;                        /**< samples per channel, >= 1 */
    uint32_t missing; /**< sample periods lost just before the first sample, or 0 */
} davar_port_block_t;

/** What read() returns. */
typedef enum {
    /** the source failed; the node counts this, and calls read again when it is stepped again */
    DAVAR_PORT_READ_FAULT = -1,
    DAVAR_PORT_READ_AGAIN = 0, /**< nothing now, try again; *block is unchanged */
    DAVAR_PORT_READ_BLOCK = 1, /**< *block is filled */
    DAVAR_PORT_READ_END = 2    /**< there are no more samples; read is not called again */
} davar_port_read_t;

/** What send() returns. */
typedef enum {
    /** this result cannot be delivered, now or later: the node counts and drops it */
    DAVAR_PORT_SEND_FAULT = -1,
    /** no room now: the node sends the same result again at its next step */
    DAVAR_PORT_SEND_AGAIN = 0,
    DAVAR_PORT_SEND_DONE = 1 /**< delivered, or copied into the port's own queue */
} davar_port_send_t;

/** The argument of fault(). */
typedef enum {
    DAVAR_PORT_FAULT_READ = 0, /**< read returned DAVAR_PORT_READ_FAULT */
    /** send returned DAVAR_PORT_SEND_FAULT; one result of one channel was lost */
    DAVAR_PORT_FAULT_SEND
} davar_port_fault_t;

/** A port. It must outlive the node that uses it, and may be in flash. */
typedef struct {
    void *context; /**< passed unchanged to every function */

    /** Returns the next block. The samples must stay valid and unchanged until the next call of
     * read. The node calls read again only after it has consumed every sample of every channel. A
     * block may have any length: one sample from a data-ready interrupt, half a DMA buffer, or a
     * page of a file. Results do not depend on it. Samples can be missing only before a block, so a
     * port that detects a loss inside a block must return two blocks. */
    davar_port_read_t (*read)(void *context, davar_port_block_t *block);

    /** Delivers one result of one channel. Called epoch by epoch and, within an epoch, in channel
     * order. *result is valid only during the call, so a port with a queue must copy it. While send
     * returns "try again", the node reads no samples. A port whose source cannot wait therefore
     * needs buffers on the read side. With law glr, call davar_glr_report once for each result, not
     * again after "try again". */
    davar_port_send_t (*send)(void *context, size_t channel, const davar_result_t *result);

    /** Microseconds on a monotonic clock. It may start at any value and wraps at 2^32, because only
     * differences are used. Null: no clock; durations are then reported as 0. */
    uint32_t (*now_us)(void *context);

    /** Called once for each fault that the node counted, for example to blink, log or restart the
     * bus. Must return and must not call the node. Null: faults are only counted. */
    void (*fault)(void *context, davar_port_fault_t what);
} davar_port_t;

#ifdef __cplusplus
}
#endif

#endif
