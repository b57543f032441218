/* davar - telemetry: DroneCAN, single frames. */
#include "number/real.h"
#include "packet.h"

#define KEY_VALUE 16370U            /* uavcan.protocol.debug.KeyValue */
#define NODE_STATUS 341U            /* uavcan.protocol.NodeStatus */
#define DRONECAN_PRIORITY 24U       /* of 31, the lowest */
#define DRONECAN_SINGLE_FRAME 0xC0U /* start and end of the transfer; the rest is its number */

#define HALF_NAN 0x7E00U
#define HALF_INFINITY 0x7C00U
#define HALF_LEAST_NORMAL 6.103515625e-05 /* 2^-14 */
#define HALF_STEPS 16777216.0             /* 2^24: below it, a step is 2^-24 */
#define HALF_INTEGER 4503599627370496.0   /* 2^52: added, it rounds to an integer */

static bool dronecan_accepts(const davar_telemetry_address_t *from)
{
    return from->node <= CAN_NODE_LAST;
}

static uint32_t dronecan_identifier(const davar_telemetry_t *telemetry, uint32_t type)
{
    return (DRONECAN_PRIORITY << 24U) | (type << 8U) | telemetry->from.node;
}

/* value, key; the length of a last array is not sent */
static void dronecan_fill(const davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    static const char *const dronecan_keys[] = {"AR", "AL", "AH", "BI", "BL", "BH"};
    packet->identifier = dronecan_identifier(telemetry, KEY_VALUE);
    davar_packet_put(packet, davar_quantity(telemetry, (quantity_t)telemetry->index), 4U);
    davar_packet_put_text(packet, dronecan_keys[telemetry->index]);
    davar_packet_put(packet, davar_axis_letter(telemetry->from.channel), 1U);
    davar_packet_put(packet, DRONECAN_SINGLE_FRAME | (telemetry->sequence & CAN_TRANSFER_MASK), 1U);
}

static void dronecan_fill_heartbeat(const davar_telemetry_t *telemetry, uint32_t uptime_s,
                                    davar_packet_t *packet)
{
    packet->identifier = dronecan_identifier(telemetry, NODE_STATUS);
    davar_packet_put_status(packet, uptime_s,
                            DRONECAN_SINGLE_FRAME | (telemetry->heartbeats & CAN_TRANSFER_MASK));
}

const davar_dialect_t davar_dronecan = {6U, 0U, dronecan_accepts, dronecan_fill,
                                        dronecan_fill_heartbeat};

/* A variance as float16, to the nearest, ties to even, and never 0 unless it is 0. */
static uint32_t half_of(double variance)
{
    const double magnitude = davar_single_limit(variance);
    if (isnan(magnitude)) {
        return HALF_NAN;
    }
    if (magnitude < HALF_LEAST_NORMAL) {
        const double steps = (magnitude * HALF_STEPS + HALF_INTEGER) - HALF_INTEGER;
        return ((steps < 1.0) && (variance > 0.0)) ? 1U : (uint32_t)steps;
    }
    const uint64_t bits = davar_bits_of_double(magnitude) - ((uint64_t)(1023U - 15U) << 52U);
    const uint64_t rounded = (bits + ((UINT64_C(1) << 41U) - 1U) + ((bits >> 42U) & 1U)) >> 42U;
    return (rounded < HALF_INFINITY) ? (uint32_t)rounded : HALF_INFINITY;
}

void davar_dronecan_covariance(const double gyro[3], const double accel[3],
                               uint8_t bytes[DAVAR_COVARIANCE_BYTES])
{
    DAVAR_ASSERT((gyro != NULL) && (accel != NULL) && (bytes != NULL));
    for (size_t i = 0U; i < 6U; i++) {
        const uint32_t found = half_of((i < 3U) ? gyro[i] : accel[i - 3U]);
        bytes[2U * i] = (uint8_t)found;
        bytes[2U * i + 1U] = (uint8_t)(found >> 8U);
    }
}
