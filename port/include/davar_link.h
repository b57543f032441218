/** @file
 * davar - the link contract: how frames leave a computer.
 *
 * port/linux implements it with SocketCAN and serial lines. In port/none, davar_link_open always
 * fails with an explanation.
 *
 * Only davar_link_wait and davar_link_close wait. After a successful open, a link counts its faults
 * and recovers by itself. */
#ifndef DAVAR_LINK_H
#define DAVAR_LINK_H

#include "davar/wire.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An open link. Fields are private. */
typedef struct davar_link davar_link_t;

/** What to open, and how. */
typedef struct {
    /** can:IFACE, slcan:PATH (a tty), or slcan:pty, which creates a pty: see davar_link_name */
    const char *where;
    bool fd;       /**< send CAN FD frames too; not on a serial line */
    uint32_t baud; /**< of a serial line; 0: unchanged */
    bool wait;     /**< open even if the interface, the file or the peer does not exist yet */
} davar_link_options_t;

/** Opens a link. The caller closes it.
 * @return Null after an error: `why` (of `size` bytes) has the cause, without a newline. */
davar_link_t *davar_link_open(const davar_link_options_t *options, char *why, size_t size);

/** Returns the interface, or the path that a peer must open. The link owns the string. */
const char *davar_link_name(const davar_link_t *link);

/** Sends a frame. Never waits.
 * @return DAVAR_PORT_SEND_DONE: the link accepted it. DAVAR_PORT_SEND_AGAIN: no room, the bus is
 *         off, or no peer has opened the pty yet; send the same frame again later (counted as a
 *         retry). DAVAR_PORT_SEND_FAULT: the link is down and the frame is lost (counted). */
davar_port_send_t davar_link_send(davar_link_t *link, const davar_frame_t *frame);

/** Counts a frame that the caller dropped before davar_link_send accepted it. */
void davar_link_dropped(davar_link_t *link);

/** Reads bus errors and unexpected bytes, detects a lost peer, and tries to reopen a lost link.
 * Call it regularly. Cheap. */
void davar_link_poll(davar_link_t *link);

/** Returns true if the interface, the tty or the reader of the pty is available. */
bool davar_link_is_up(const davar_link_t *link);

/** Waits until there may be room, at most `milliseconds`. */
void davar_link_wait(davar_link_t *link, uint32_t milliseconds);

/** Writes the link's counters into *health, from DAVAR_HEALTH_FRAMES_DROPPED to
 * DAVAR_HEALTH_NOISE_BYTES. */
void davar_link_health(const davar_link_t *link, davar_wire_health_t *health);

/** Returns a number for davar_encoder_session, derived from a clock: 1 to 255. 0: there is no
 * clock. */
uint8_t davar_link_session(void);

/** Waits until a serial peer has read everything, but at most two seconds for a peer that stops
 * reading. Then frees the link. Null is allowed. */
void davar_link_close(davar_link_t *link);

#ifdef __cplusplus
}
#endif

#endif
