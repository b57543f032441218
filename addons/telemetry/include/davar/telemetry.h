/** @file
 * davar - telemetry: results in the dialects of autopilots, MAVLink, DroneCAN and Cyphal.
 *
 * ```
 * result -> davar_telemetry_begin -> davar_telemetry_next (until false) -> packets
 * clock  -> davar_telemetry_heartbeat (true once a second) -> packet
 * ```
 *
 * A dialect is a constant, as a window law is. A program links only the dialects that it names.
 * docs/DIALECTS.md describes the messages. No heap, no I/O.
 *
 * An absent coefficient is sent as NaN, so that a receiver does not keep an old value. Magnitudes
 * have the same limits as in davar/can.h.
 *
 * Threads: one object belongs to one thread. No function allocates memory or blocks. */
#ifndef DAVAR_TELEMETRY_H
#define DAVAR_TELEMETRY_H

#include "davar/floor.h"
#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_PACKET_BYTES 112U         /**< longest packet */
#define DAVAR_TELEMETRY_CHANNEL_LAST 9U /**< 0 to 9; in names 0, 1 and 2 are X, Y and Z */
#define DAVAR_COVARIANCE_BYTES 12U      /**< of davar_dronecan_covariance */

/** A packet of MAVLink, or a CAN frame of DroneCAN or Cyphal. */
typedef struct {
    uint32_t identifier;              /**< CAN: extended, 29 bit. MAVLink: 0 */
    uint8_t length;                   /**< CAN: at most 8; above, it is a CAN FD frame of 64 */
    uint8_t data[DAVAR_PACKET_BYTES]; /**< the first `length` bytes count */
} davar_packet_t;

/** Who sends, and what. A sender is a node (MAVLink: a component of a system). Receivers count its
 * packets, so it needs one encoder for all its channels: davar_telemetry_set_channel. Two encoders
 * need two node numbers. */
typedef struct {
    uint8_t channel;  /**< the axis: 0 to DAVAR_TELEMETRY_CHANNEL_LAST */
    uint8_t node;     /**< MAVLink: component, 1 to 255. DroneCAN, Cyphal: node, 1 to 127 */
    uint8_t system;   /**< MAVLink: system, 1 to 255. Others: not used */
    uint16_t subject; /**< Cyphal: subject, 0 to 8191. Others: not used */
} davar_telemetry_address_t;

/** A dialect: one of the constants below. */
typedef struct davar_dialect davar_dialect_t;

/** An encoder of one sender, about 64 bytes. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    const davar_dialect_t *dialect;
    const davar_result_t *result;
    const davar_glr_report_t *report;
    const davar_floor_result_t *floor;
    uint64_t time_us;
    double rate_hz;
    uint32_t heartbeat_us; /* when the next heartbeat is due, modulo 2^32 */
    davar_telemetry_address_t from;
    uint8_t index;      /* of the next packet of the result */
    uint8_t sequence;   /* packets so far, without heartbeats, modulo 256 */
    uint8_t heartbeats; /* heartbeats so far, modulo 256 */
} davar_telemetry_t;

/** Fields are private. */
struct davar_dialect {
    /** @privatesection */
    uint8_t packets; /* of a result, */
    uint8_t floors;  /* ... and more of them with a floor */
    bool (*accepts)(const davar_telemetry_address_t *from);
    void (*fill)(const davar_telemetry_t *telemetry, davar_packet_t *packet);
    void (*fill_heartbeat)(const davar_telemetry_t *telemetry, uint32_t uptime_s,
                           davar_packet_t *packet);
};

/** MAVLink 2: NAMED_VALUE_FLOAT ARW_X (deg/sqrt(h)) and BI_X (deg/h), then DEBUG_FLOAT_ARRAY
 * `davar` with the channel as its array_id. Three packets per result; with a floor, FLR_X too. */
extern const davar_dialect_t davar_mavlink;

/** MAVLink 2: GYRO_NOISE, which tools/dialects/davar.xml proposes. One packet per result. */
extern const davar_dialect_t davar_mavlink_gyro_noise;

/** DroneCAN: uavcan.protocol.debug.KeyValue ARX, ALX and AHX (ARW and its 95 % limits), BIX, BLX
 * and BHX (bias instability). Six frames per result. */
extern const davar_dialect_t davar_dronecan;

/** Cyphal/CAN FD: davar.Noise.1.0 (tools/dialects/davar/Noise.1.0.dsdl). One frame per result. */
extern const davar_dialect_t davar_cyphal;

/** Starts an encoder. `rate_hz` is the sample rate of the instance. The address is copied.
 * @return False, with *telemetry unchanged, if the dialect does not allow the address.
 *
 * Cost: O(1). */
DAVAR_NODISCARD bool davar_telemetry_init(davar_telemetry_t *telemetry,
                                          const davar_dialect_t *dialect,
                                          const davar_telemetry_address_t *from, double rate_hz);

/** Sets the channel of the results that follow. Call it between two results.
 * @return False, with *telemetry unchanged, above DAVAR_TELEMETRY_CHANNEL_LAST. Cost: O(1). */
bool davar_telemetry_set_channel(davar_telemetry_t *telemetry, uint8_t channel);

/** Adds *floor, the newest result of davar_floor_take, to every following result; null stops that.
 * Only davar_mavlink sends it. The encoder reads it as it does *result. Call it after
 * davar_telemetry_init. Cost: O(1). */
void davar_telemetry_floor(davar_telemetry_t *telemetry, const davar_floor_result_t *floor);

/** Starts the packets of one result.
 * *report comes from davar_glr_report. Without it (null), the flags young and alarm are sent as 0.
 * The encoder reads *result and *report until davar_telemetry_next returns false; do not change
 * them before. `time_us` is the time since boot in microseconds, as the autopilot counts it; only
 * MAVLink sends it. Cost: O(1). */
void davar_telemetry_begin(davar_telemetry_t *telemetry, const davar_result_t *result,
                           const davar_glr_report_t *report, uint64_t time_us);

/** Writes the next packet.
 * @return False after the last packet; *packet is then unchanged. A packet counts as sent: if the
 *         caller drops it, the receiver detects a hole in the sequence.
 *
 * Cost: O(length). */
bool davar_telemetry_next(davar_telemetry_t *telemetry, davar_packet_t *packet);

/** Writes a heartbeat once a second: MAVLink HEARTBEAT, DroneCAN uavcan.protocol.NodeStatus or
 * Cyphal uavcan.node.Heartbeat. Receivers list a sender only if it sends them. Call it several times
 * a second if the address belongs to this encoder alone. Do not call it if other code sends the
 * heartbeat of this address. `time_us` is the time since boot. A late call does not delay the next
 * heartbeat. After a call a second late or more, and after a clock that jumped back, the seconds
 * count from that call.
 * @return False if none is due; *packet is then unchanged.
 *
 * Cost: O(1). */
bool davar_telemetry_heartbeat(davar_telemetry_t *telemetry, uint64_t time_us,
                               davar_packet_t *packet);

/** Writes the diagonal of uavcan.equipment.ahrs.RawIMU.covariance: six float16, little endian.
 * `gyro` and `accel` are variances of X, Y and Z, (rad/s)^2 (davar/kalman.h) and (m/s^2)^2. NaN is
 * unknown; a negative variance is sent as NaN. A positive variance below 2^-24, the least of
 * float16, is sent as 2^-24, because 0 would mean no noise. 65520 and above is sent as infinity.
 * Cost: O(1). */
void davar_dronecan_covariance(const double gyro[3], const double accel[3],
                               uint8_t bytes[DAVAR_COVARIANCE_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
