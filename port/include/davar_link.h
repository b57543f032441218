/** @file
 * davar - the link contract: how packets leave a computer. A packet is a CAN frame or a packet of
 * MAVLink.
 *
 * port/linux implements it with SocketCAN, serial lines and UDP. In port/none, davar_link_open always
 * fails with an explanation.
 *
 * Only davar_link_wait and davar_link_close wait. After a successful open, a link counts its faults
 * and recovers by itself. */
#ifndef DAVAR_LINK_H
#define DAVAR_LINK_H

#include "davar/can.h"
#include "davar/telemetry.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An open link. Fields are private. */
typedef struct davar_link davar_link_t;

/** Where packets can go. */
#define DAVAR_LINK_FORMS                                                                           \
    "can:IFACE, slcan:PATH, mavlink:udp:HOST:PORT, mavlink:serial:PATH, dronecan:IFACE or "        \
    "cyphal:IFACE"

/** Returns the dialect of a link, and the usual address of a sender on it: MAVLink system 1 and
 * component 191 + channel, node 100 + channel, subject 3700. Null: the link has davar's own
 * frames. */
const davar_dialect_t *davar_link_dialect(const char *where, uint8_t channel,
                                          davar_telemetry_address_t *address);

/** Returns a frame as a packet. */
static inline davar_packet_t davar_link_packet(const davar_frame_t *frame)
{
    davar_packet_t packet = {.identifier = frame->identifier, .length = frame->length};
    for (size_t i = 0; i < frame->length; i++) {
        packet.data[i] = frame->data[i];
    }
    return packet;
}

/** What to open, and how. */
typedef struct {
    /** One of DAVAR_LINK_FORMS. PATH is a tty, or pty, which creates a pty: see davar_link_name */
    const char *where;
    bool fd;       /**< can: send CAN FD frames too */
    uint32_t baud; /**< of a serial line; 0: unchanged */
    bool wait;     /**< open even if the interface or the file does not exist yet, or the network is
                      * down. The name of a host is resolved once, in davar_link_open */
} davar_link_options_t;

/** Opens a link. The caller closes it.
 * @return Null after an error: `why` (of `size` bytes) has the cause, without a newline. */
davar_link_t *davar_link_open(const davar_link_options_t *options, char *why, size_t size);

/** Returns the interface, or the path that a peer must open. The link owns the string. */
const char *davar_link_name(const davar_link_t *link);

/** Sends a packet. Never waits.
 * @return DAVAR_PORT_SEND_DONE: the link accepted it (UDP: a packet that no peer receives is counted
 *         as dropped if the peer's computer reports it). DAVAR_PORT_SEND_AGAIN: no room, the bus is
 *         off, or no peer has opened the pty yet; send the same packet again later (counted as a
 *         retry). DAVAR_PORT_SEND_FAULT: the link is down and the packet is lost (counted). */
davar_port_send_t davar_link_send(davar_link_t *link, const davar_packet_t *packet);

/** Counts a packet that the caller dropped before davar_link_send accepted it. */
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
void davar_link_health(const davar_link_t *link, davar_can_health_t *health);

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
