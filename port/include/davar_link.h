/* davar - the link contract: where frames leave a computer. port/linux implements it with SocketCAN and serial lines,
 * port/none refuses politely.
 *
 * A link never waits but in davar_link_wait and davar_link_close. What happens to it after a good open is weather: it is
 * counted, and the link recovers by itself. */
#ifndef DAVAR_LINK_H
#define DAVAR_LINK_H

#include "davar/wire.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct davar_link davar_link_t;

typedef struct {
    const char *
        where; /* can:IFACE, slcan:PATH (a tty), or slcan:pty, which makes a pty: see davar_link_name */
    bool fd;       /* CAN FD frames too; not on a serial line */
    uint32_t baud; /* of a serial line; 0: leave it as it is */
    bool wait;     /* open even when the interface, the file or the peer is not there yet */
} davar_link_options_t;

/* Opens a link, for the caller to close. Null: `why` (of `size` bytes) says what is wrong, without a newline. */
davar_link_t *davar_link_open(const davar_link_options_t *options, char *why, size_t size);

/* The interface, or the path a peer should open. Belongs to the link. */
const char *davar_link_name(const davar_link_t *link);

/* DONE: the frame is on its way. AGAIN: no room, the bus is off, or nobody listens on the pty yet; offer the same frame
 * later (counted as a retry). FAULT: the link is down and the frame is lost (counted). */
davar_port_send_t davar_link_send(davar_link_t *link, const davar_frame_t *frame);

/* Says that a frame was given up on before davar_link_send took it. */
void davar_link_dropped(davar_link_t *link);

/* Reads bus errors and noise, notices a lost peer, tries to reopen what is lost. Call it now and then. Cheap. */
void davar_link_poll(davar_link_t *link);

/* Is the interface, the tty or the pty's reader there? */
bool davar_link_is_up(const davar_link_t *link);

/* Waits until there may be room, at most so long. */
void davar_link_wait(davar_link_t *link, uint32_t milliseconds);

/* Writes the link's counters (DAVAR_HEALTH_FRAMES_DROPPED .. DAVAR_HEALTH_NOISE_BYTES). */
void davar_link_health(const davar_link_t *link, davar_wire_health_t *health);

/* A number for davar_encoder_session: by a clock, 1 to 255; 0 where there is none. */
uint8_t davar_link_session(void);

/* Waits until a serial peer has read everything (two seconds for one that stops reading) and frees the link. Null is
 * allowed. */
void davar_link_close(davar_link_t *link);

#ifdef __cplusplus
}
#endif

#endif
