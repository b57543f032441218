/* davar - telemetry: Cyphal/CAN FD, single frames. */
#include "packet.h"

#define CYPHAL_PRIORITY 5U         /* of 7, the lowest */
#define CYPHAL_MESSAGE 0x00600000U /* not a service; two reserved bits are 1 */
#define CYPHAL_SUBJECT_LAST 8191U
#define CYPHAL_HEARTBEAT 7509U /* subject of uavcan.node.Heartbeat */
#define CYPHAL_FRAME_BYTES 64U
#define CYPHAL_SINGLE_FRAME 0xE0U /* start, end, toggle; the rest is the transfer number */

static bool cyphal_accepts(const davar_telemetry_address_t *from)
{
    return (from->node <= CAN_NODE_LAST) && (from->subject <= CYPHAL_SUBJECT_LAST);
}

static uint32_t cyphal_identifier(const davar_telemetry_t *telemetry, uint32_t subject)
{
    return (CYPHAL_PRIORITY << 26U) | CYPHAL_MESSAGE | (subject << 8U) | telemetry->from.node;
}

static void cyphal_fill(const davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    packet->identifier = cyphal_identifier(telemetry, telemetry->from.subject);
    davar_packet_put_result(packet, telemetry);
    packet->length = CYPHAL_FRAME_BYTES - 1U; /* one byte of padding */
    davar_packet_put(packet, CYPHAL_SINGLE_FRAME | (telemetry->sequence & CAN_TRANSFER_MASK), 1U);
}

static void cyphal_fill_heartbeat(const davar_telemetry_t *telemetry, uint32_t uptime_s,
                                  davar_packet_t *packet)
{
    packet->identifier = cyphal_identifier(telemetry, CYPHAL_HEARTBEAT);
    davar_packet_put_status(packet, uptime_s,
                            CYPHAL_SINGLE_FRAME | (telemetry->heartbeats & CAN_TRANSFER_MASK));
}

const davar_dialect_t davar_cyphal = {1U, 0U, cyphal_accepts, cyphal_fill, cyphal_fill_heartbeat};
