/* davar-node - a queue of packets before the link, so that a slow bus never delays the samples. */
#ifndef OUTBOX_H
#define OUTBOX_H

#include "davar_link.h"

#define OUTBOX_PACKETS 512U /* about ten full results */

typedef struct {
    davar_link_t *link;
    size_t first;
    size_t count;
    davar_packet_t packet[OUTBOX_PACKETS];
} outbox_t;

/* Queues a packet. If there is no room, the packet is dropped and counted. */
void outbox_put_packet(outbox_t *outbox, const davar_packet_t *packet);

/* Queues a frame in the same way. */
void outbox_put(outbox_t *outbox, const davar_frame_t *frame);

/* Queues the frames of the result that the encoder has begun. */
void outbox_put_all(outbox_t *outbox, davar_encoder_t *encoder);

/* Queues the packets of the result that the encoder of a dialect has begun. */
void outbox_put_telemetry(outbox_t *outbox, davar_telemetry_t *telemetry);

/* Sends as many packets as the link accepts now. */
void outbox_flush(outbox_t *outbox);

/* Drops and counts the remaining packets. */
void outbox_drop(outbox_t *outbox);

#endif
