/** @file
 * davar - the receiver of the frames of davar/can.h: one frame to its values.
 *
 * Call davar_decode for each frame. davar/can.h explains how frames join to results. No heap, no
 * I/O; the function keeps no state. */
#ifndef DAVAR_CAN_DECODE_H
#define DAVAR_CAN_DECODE_H

#include "davar/can.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What davar_decode returns: the frame is valid, or why not. */
typedef enum {
    DAVAR_DECODED = 0,    /**< valid */
    DAVAR_DECODE_FOREIGN, /**< not an identifier of this base */
    DAVAR_DECODE_LENGTH,  /**< not the length of this message */
    DAVAR_DECODE_CRC,     /**< damaged */
    /** an index or a value that no sender writes: damage that passed the checksum */
    DAVAR_DECODE_VALUE
} davar_decode_status_t;

/** The content of one frame. Absent values are NaN. Units as in davar_result_t. */
typedef struct {
    davar_message_t message; /**< decides which fields below have a value (addons/can/DESIGN.md) */
    uint8_t channel;         /**< from the identifier */
    uint8_t counter;         /**< Counter, 0..15 */
    /** Result: Counter of the DAVAR_State it belongs to, 0..15; not in State, ResultFd, Raw */
    uint8_t result;
    uint8_t session; /**< DAVAR_End, DAVAR_Health, DAVAR_Setup: see davar_encoder_session */
    /** TauIndex; Kind (coefficient, + 5 for low, + 10 for high); HealthIndex; Item; MonitorIndex;
     * Form; ChangeItem; Frames; FloorKind (0: value, 1: low, 2: high) */
    uint8_t index;
    float value; /**< the float32 of the message; in DAVAR_ResultFd ARW */
    /** Epoch (24 bits in DAVAR_ResultFd), health count, stride, cluster size, Index (18 bits),
     * Digest */
    uint32_t number;
    /** DAVAR_Raw: the counts from sample `number` on; two of a pair, one of DAVAR_RAW_COUNT */
    int32_t count[2];
    uint32_t window_samples; /**< as in davar_result_t */
    bool unstable;           /**< as in davar_result_t */
    /** of ARW or of the Allan deviation: half the 95 % interval over the value */
    float relative_uncertainty;
    /** DAVAR_Arw, DAVAR_ResultFd: why ARW is absent; DAVAR_NOISE_UNKNOWN if it is present */
    davar_noise_t noise;
    /** DAVAR_Monitor, health: index of the tau that decides it; DAVAR_MONITOR_NO_TAU: none */
    uint8_t worst;
    davar_floor_why_t floor_why; /**< DAVAR_Floor: as in davar_floor_result_t */
    float kurtosis;              /**< as in davar_result_t */
    float contribution;          /**< as in davar_result_t */
    bool alarm;                  /**< DAVAR_Change: as in davar_glr_report_t */
    bool young;                  /**< DAVAR_Change: as in davar_glr_report_t */
    uint32_t change_m;           /**< DAVAR_Change: m of davar_change_t */
    uint32_t cut_age_samples;    /**< item DAVAR_CHANGE_CUT only; 2^20 - 1: that or more */
    float dispersion;            /**< item DAVAR_CHANGE_CUT only */
    float adev[DAVAR_FD_TAUS];   /**< DAVAR_ResultFd */
    float coefficient[DAVAR_COEFFICIENT_COUNT]; /**< DAVAR_ResultFd */
} davar_decoded_t;

/** Decodes one frame of channel 0 and up at identifier `base`. Rejects values that cannot occur: a
 * deviation or coefficient that is negative, infinite (except an upper limit) or outside
 * DAVAR_CAN_LEAST .. DAVAR_CAN_MOST; a rate of 0; a window, stride, cluster size or number of
 * frames of 0.
 * @return DAVAR_DECODED if *wire is filled, otherwise the first reason. Cost: O(length). */
davar_decode_status_t davar_decode(const davar_frame_t *frame, uint16_t base,
                                   davar_decoded_t *wire);

#ifdef __cplusplus
}
#endif

#endif
