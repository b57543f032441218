/* davar-node - frames on their way out: a queue in front of the link, so that a slow bus never holds up the samples. */
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

/* Takes a frame; one that finds no room is dropped and counted. */
void outbox_put(outbox_t *outbox, const davar_frame_t *frame);

/* Takes the frames of the result that the encoder has begun. */
void outbox_put_all(outbox_t *outbox, davar_encoder_t *encoder);

/* Sends what goes now. */
void outbox_flush(outbox_t *outbox);

/* Gives up what is left: dropped and counted. */
void outbox_drop(outbox_t *outbox);

#endif
