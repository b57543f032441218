/* davar - telemetry: MAVLink 2. */
#include "number/real.h"
#include "packet.h"

#define MAVLINK_START 0xFDU
#define MAVLINK_HEADER_BYTES 10U
#define EPOCH_MASK 0xFFFFFFU

/* The number of a message, and the byte of its definition that the checksum covers. */
#define HEARTBEAT 0U
#define HEARTBEAT_EXTRA 50U
#define NAMED_VALUE_FLOAT 251U
#define NAMED_VALUE_FLOAT_EXTRA 170U
#define DEBUG_FLOAT_ARRAY 350U
#define DEBUG_FLOAT_ARRAY_EXTRA 232U
#define GYRO_NOISE 58800U
#define GYRO_NOISE_EXTRA 4U

#define MAV_TYPE_ONBOARD_CONTROLLER 18U
#define MAV_AUTOPILOT_INVALID 8U /* not an autopilot */
#define MAV_STATE_ACTIVE 4U
#define MAVLINK_VERSION 3U

/* CRC-16/MCRF4XX of one more byte. */
static uint32_t crc_of_byte(uint32_t crc, uint32_t byte)
{
    uint32_t mixed = (byte ^ crc) & 0xFFU;
    mixed = (mixed ^ (mixed << 4U)) & 0xFFU;
    return (crc >> 8U) ^ (mixed << 8U) ^ (mixed << 3U) ^ (mixed >> 4U);
}

static void mavlink_open(const davar_telemetry_t *telemetry, uint32_t message,
                         davar_packet_t *packet)
{
    davar_packet_put(packet, MAVLINK_START, 4U); /* length and flags: 0 so far */
    davar_packet_put(packet, (uint32_t)telemetry->sequence + telemetry->heartbeats, 1U);
    davar_packet_put(packet, telemetry->from.system | ((uint32_t)telemetry->from.node << 8U), 2U);
    davar_packet_put(packet, message, 3U);
}

/* MAVLink 2 truncates trailing zero bytes of a payload, but keeps the first byte. */
static void mavlink_close(uint32_t extra, davar_packet_t *packet)
{
    uint32_t crc = 0xFFFFU;
    while ((packet->length > MAVLINK_HEADER_BYTES + 1U) &&
           (packet->data[packet->length - 1U] == 0U)) {
        packet->length--;
    }
    packet->data[1] = (uint8_t)(packet->length - MAVLINK_HEADER_BYTES);
    for (uint32_t i = 1U; i < packet->length; i++) {
        crc = crc_of_byte(crc, packet->data[i]);
    }
    davar_packet_put(packet, crc_of_byte(crc, extra), 2U);
}

/* time_boot_ms, value, name */
static void fill_named(const davar_telemetry_t *telemetry, const char *name, uint32_t bits,
                       davar_packet_t *packet)
{
    mavlink_open(telemetry, NAMED_VALUE_FLOAT, packet);
    davar_packet_put(packet, (uint32_t)(telemetry->time_us / 1000U), 4U);
    davar_packet_put(packet, bits, 4U);
    davar_packet_put_text(packet, name);
    davar_packet_put(packet, davar_axis_letter(telemetry->from.channel), 1U);
    mavlink_close(NAMED_VALUE_FLOAT_EXTRA, packet);
}

static uint32_t floor_bits(float value)
{
    return davar_single_bits(davar_single_magnitude((double)value));
}

/* time_usec, array_id, name (10 bytes), data: the quantities, window_samples, state, epoch modulo
 * 2^24, which a float32 holds; with a floor, that with its limits and why */
static void fill_array(const davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    const davar_result_t *result = telemetry->result;
    mavlink_open(telemetry, DEBUG_FLOAT_ARRAY, packet);
    davar_packet_put_time(packet, telemetry->time_us);
    davar_packet_put(packet, telemetry->from.channel, 2U);
    davar_packet_put_text(packet, "davar");
    davar_packet_put(packet, 0U, 5U);
    davar_packet_put_quantities(packet, telemetry);
    davar_packet_put(packet, davar_bits_of_float((float)result->window_samples), 4U);
    davar_packet_put(packet, davar_bits_of_float((float)davar_quantity_state(telemetry)), 4U);
    davar_packet_put(packet, davar_bits_of_float((float)(result->epoch & EPOCH_MASK)), 4U);
    if (telemetry->floor != NULL) {
        davar_packet_put(packet, floor_bits(telemetry->floor->value), 4U);
        davar_packet_put(packet, floor_bits(telemetry->floor->low), 4U);
        davar_packet_put(packet,
                         davar_single_bits(davar_single_limit((double)telemetry->floor->high)), 4U);
        davar_packet_put(packet, davar_bits_of_float((float)telemetry->floor->why), 4U);
    }
    mavlink_close(DEBUG_FLOAT_ARRAY_EXTRA, packet);
}

static void mavlink_fill(const davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    if (telemetry->index == 0U) {
        fill_named(telemetry, "ARW_", davar_quantity(telemetry, QUANTITY_ARW), packet);
    } else if (telemetry->index == 1U) {
        fill_named(telemetry, "BI_", davar_quantity(telemetry, QUANTITY_BI), packet);
    } else if (telemetry->index == 2U) {
        fill_array(telemetry, packet);
    } else {
        fill_named(telemetry, "FLR_", floor_bits(telemetry->floor->value), packet);
    }
}

/* Fields in the order on the wire, which is by size. */
static void fill_gyro_noise(const davar_telemetry_t *telemetry, davar_packet_t *packet)
{
    mavlink_open(telemetry, GYRO_NOISE, packet);
    davar_packet_put_time(packet, telemetry->time_us);
    davar_packet_put_result(packet, telemetry);
    mavlink_close(GYRO_NOISE_EXTRA, packet);
}

static bool mavlink_accepts(const davar_telemetry_address_t *from)
{
    return from->system > 0U;
}

/* custom_mode, type, autopilot, base_mode, system_status, mavlink_version */
static void mavlink_fill_heartbeat(const davar_telemetry_t *telemetry, uint32_t uptime_s,
                                   davar_packet_t *packet)
{
    (void)uptime_s;
    mavlink_open(telemetry, HEARTBEAT, packet);
    davar_packet_put(packet, 0U, 4U);
    davar_packet_put(packet, MAV_TYPE_ONBOARD_CONTROLLER | (MAV_AUTOPILOT_INVALID << 8U), 2U);
    davar_packet_put(packet, MAV_STATE_ACTIVE << 8U, 2U); /* base_mode: 0 */
    davar_packet_put(packet, MAVLINK_VERSION, 1U);
    mavlink_close(HEARTBEAT_EXTRA, packet);
}

const davar_dialect_t davar_mavlink = {3U, 1U, mavlink_accepts, mavlink_fill,
                                       mavlink_fill_heartbeat};
const davar_dialect_t davar_mavlink_gyro_noise = {1U, 0U, mavlink_accepts, fill_gyro_noise,
                                                  mavlink_fill_heartbeat};
