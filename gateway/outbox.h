/* davar-node - a queue of frames before the link, so that a slow bus never delays the samples. */
#ifndef OUTBOX_H
#define OUTBOX_H

#include "davar_link.h"

#define OUTBOX_FRAMES 512U /* about ten full results */

typedef struct {
    davar_link_t *link;
    size_t first;
    size_t count;
    davar_frame_t frame[OUTBOX_FRAMES];
} outbox_t;

/* Queues a frame. If there is no room, the frame is dropped and counted. */
void outbox_put(outbox_t *outbox, const davar_frame_t *frame);

/* Queues the frames of the result that the encoder has begun. */
void outbox_put_all(outbox_t *outbox, davar_encoder_t *encoder);

/* Sends as many frames as the link accepts now. */
void outbox_flush(outbox_t *outbox);

/* Drops and counts the remaining frames. */
void outbox_drop(outbox_t *outbox);

#endif
