/* davar-node - outbox. */
#include "outbox.h"

void outbox_put_packet(outbox_t *outbox, const davar_packet_t *packet)
{
    if (outbox->count == OUTBOX_PACKETS) {
        davar_link_dropped(outbox->link);
        return;
    }
    outbox->packet[(outbox->first + outbox->count) % OUTBOX_PACKETS] = *packet;
    outbox->count++;
}

void outbox_put(outbox_t *outbox, const davar_frame_t *frame)
{
    const davar_packet_t packet = davar_link_packet(frame);
    outbox_put_packet(outbox, &packet);
}

void outbox_put_all(outbox_t *outbox, davar_encoder_t *encoder)
{
    davar_frame_t frame;
    while (davar_encoder_next(encoder, &frame)) {
        outbox_put(outbox, &frame);
    }
}

void outbox_put_telemetry(outbox_t *outbox, davar_telemetry_t *telemetry)
{
    davar_packet_t packet;
    while (davar_telemetry_next(telemetry, &packet)) {
        outbox_put_packet(outbox, &packet);
    }
}

void outbox_flush(outbox_t *outbox)
{
    while ((outbox->count > 0U) && (davar_link_send(outbox->link, &outbox->packet[outbox->first]) !=
                                    DAVAR_PORT_SEND_AGAIN)) {
        outbox->first = (outbox->first + 1U) % OUTBOX_PACKETS;
        outbox->count--;
    }
}

void outbox_drop(outbox_t *outbox)
{
    for (; outbox->count > 0U; outbox->count--) {
        davar_link_dropped(outbox->link);
    }
}
