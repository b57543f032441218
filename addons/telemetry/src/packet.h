/* davar - what the dialects share: the list of quantities, and bytes in a packet. */
#ifndef DAVAR_SRC_PACKET_H
#define DAVAR_SRC_PACKET_H

#include "davar/telemetry.h"
#include "number/strict.h"

#define CAN_NODE_LAST 127U      /* of DroneCAN and Cyphal */
#define CAN_TRANSFER_MASK 0x1FU /* the number of a transfer in its last byte */

/* The quantities of a result, in the order in which every dialect lists them. */
typedef enum {
    QUANTITY_ARW = 0, /* deg/sqrt(h); then its 95 % limits */
    QUANTITY_ARW_LOW,
    QUANTITY_ARW_HIGH,
    QUANTITY_BI, /* deg/h */
    QUANTITY_BI_LOW,
    QUANTITY_BI_HIGH,
    QUANTITY_RRW, /* deg/h/sqrt(h) */
    QUANTITY_RRW_LOW,
    QUANTITY_RRW_HIGH,
    QUANTITY_RR, /* deg/h^2 */
    QUANTITY_QN, /* deg */
    QUANTITY_KURTOSIS,
    QUANTITY_RATE, /* Hz */
    QUANTITY_COUNT
} quantity_t;

/* The bits of one quantity as float32. */
uint32_t davar_quantity(const davar_telemetry_t *telemetry, quantity_t quantity);

/* Bits 0 to 2: davar_noise_t. Bit 3: unstable. Bit 4: young. Bit 5: alarm. */
uint8_t davar_quantity_state(const davar_telemetry_t *telemetry);

/* The axis in a name: X, Y, Z, 3, ... 9. */
uint8_t davar_axis_letter(uint8_t channel);

/* Append the low `bytes` bytes of a value, zeros after the fourth; a time in 8. Little endian. */
void davar_packet_put(davar_packet_t *packet, uint32_t value, uint32_t bytes);
void davar_packet_put_time(davar_packet_t *packet, uint64_t time_us);

/* Appends the characters of a text. */
void davar_packet_put_text(davar_packet_t *packet, const char *text);

/* Appends every quantity. */
void davar_packet_put_quantities(davar_packet_t *packet, const davar_telemetry_t *telemetry);

/* Appends a status of a node without faults, as NodeStatus of DroneCAN and Heartbeat of Cyphal have
 * it, and the last byte of its frame. */
void davar_packet_put_status(davar_packet_t *packet, uint32_t uptime_s, uint32_t last);

/* Appends the fields that davar.Noise.1.0 and GYRO_NOISE have in common: epoch, window_samples,
 * every quantity, channel, state. */
void davar_packet_put_result(davar_packet_t *packet, const davar_telemetry_t *telemetry);

#endif
