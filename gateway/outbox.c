/* davar-node - outbox. */
#include "outbox.h"

void outbox_put(outbox_t *outbox, const davar_frame_t *frame)
{
    if (outbox->count == OUTBOX_FRAMES) {
        davar_link_dropped(outbox->link);
        return;
    }
    outbox->frame[(outbox->first + outbox->count) % OUTBOX_FRAMES] = *frame;
    outbox->count++;
}

void outbox_put_all(outbox_t *outbox, davar_encoder_t *encoder)
{
    davar_frame_t frame;
    while (davar_encoder_next(encoder, &frame)) {
        outbox_put(outbox, &frame);
    }
}

void outbox_flush(outbox_t *outbox)
{
    while ((outbox->count > 0U) && (davar_link_send(outbox->link, &outbox->frame[outbox->first]) !=
                                    DAVAR_PORT_SEND_AGAIN)) {
        outbox->first = (outbox->first + 1U) % OUTBOX_FRAMES;
        outbox->count--;
    }
}

void outbox_drop(outbox_t *outbox)
{
    for (; outbox->count > 0U; outbox->count--) {
        davar_link_dropped(outbox->link);
    }
}
