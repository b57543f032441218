/** @file
 * davar - can: results as frames for a CAN bus or a serial line.
 *
 * ```
 * result -> davar_encoder_begin -> davar_encoder_next (until false) -> frames
 * ```
 *
 * tools/davar.dbc defines the layout, and addons/can/DESIGN.md explains it. Tests compare both with
 * this encoder bit by bit. No heap, no I/O, no floating-point division.
 *
 * A receiver joins the frames that carry the same Result. The result is complete if their number
 * and the sum of davar_frame_digest over them match its DAVAR_End. Otherwise a frame was lost or
 * belongs to another result, and the receiver drops them. davar/can_decode.h is davar's
 * decoder, and davar/slcan.h writes frames as text for a serial line.
 *
 * Threads: one encoder belongs to one thread. No function allocates memory or blocks. */
#ifndef DAVAR_CAN_H
#define DAVAR_CAN_H

#include "davar/floor.h"
#include "davar/monitor.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_CAN_BASE 0x5D0U    /**< default identifier of channel 0; standard 11 bit */
#define DAVAR_CAN_STEP 16U       /**< identifiers per channel */
#define DAVAR_CAN_LAST_ID 0x7FFU /**< largest identifier of a standard frame */
#define DAVAR_FD_TAUS 8U         /**< Allan deviations in one DAVAR_ResultFd */
#define DAVAR_CAN_LEAST 1e-30F   /**< smallest magnitude of a float on the wire, except 0 */
#define DAVAR_CAN_MOST 1e30F     /**< largest magnitude of a float on the wire */

/** Message of a channel: identifier = base + 16 channel + message. */
typedef enum {
    DAVAR_MESSAGE_ARW = 0,          /**< DAVAR_Arw: angle random walk and its uncertainty */
    DAVAR_MESSAGE_STATE = 1,        /**< DAVAR_State: epoch, window and flags; first of a result */
    DAVAR_MESSAGE_STATIONARITY = 2, /**< DAVAR_Stationarity: kurtosis and contribution */
    DAVAR_MESSAGE_ADEV = 3,         /**< DAVAR_Adev: Allan deviation of one tau */
    DAVAR_MESSAGE_COEFFICIENT = 4,  /**< DAVAR_Coefficient: a coefficient or a limit of it */
    DAVAR_MESSAGE_HEALTH = 5,       /**< DAVAR_Health: one counter (davar_health_item_t) */
    DAVAR_MESSAGE_SETUP = 6,        /**< DAVAR_Setup: one setting (davar_setup_item_t) */
    DAVAR_MESSAGE_MONITOR = 7,      /**< DAVAR_Monitor: health, or the deviation of one tau */
    DAVAR_MESSAGE_RESULT_FD = 8,    /**< DAVAR_ResultFd: a result in 64 bytes, for CAN FD */
    DAVAR_MESSAGE_RAW = 9,          /**< DAVAR_Raw: samples (davar_raw_form_t) */
    DAVAR_MESSAGE_CHANGE = 10,      /**< DAVAR_Change: a change of the noise (law glr) */
    DAVAR_MESSAGE_END = 11,         /**< DAVAR_End: last of a result; frames and digest */
    DAVAR_MESSAGE_FLOOR = 12,       /**< DAVAR_Floor: the floor or a limit of it */
    DAVAR_MESSAGE_COUNT = 13        /**< number of messages */
} davar_message_t;

/** Counters of losses and faults; DAVAR_Health carries one of them at a time. davar_can_health fills
 * the first six and the last three from davar_health_t, the sender the others. */
typedef enum {
    DAVAR_HEALTH_GAPS = 0,           /**< gaps */
    DAVAR_HEALTH_MISSING_SAMPLES,    /**< samples */
    DAVAR_HEALTH_SATURATED_SAMPLES,  /**< samples */
    DAVAR_HEALTH_NOT_FINITE_SAMPLES, /**< samples */
    DAVAR_HEALTH_WINDOW_RESTARTS,    /**< windows discarded */
    DAVAR_HEALTH_RESULTS_MISSED,     /**< results replaced before they were read */
    DAVAR_HEALTH_FRAMES_DROPPED,     /**< link: frames encoded but never sent */
    DAVAR_HEALTH_SEND_RETRIES,       /**< link: times it had no room */
    DAVAR_HEALTH_ERROR_PASSIVE,      /**< link: times the bus became error passive */
    DAVAR_HEALTH_BUS_OFF,            /**< link: times it went bus-off */
    DAVAR_HEALTH_LINK_LOST,          /**< link: times the interface or serial peer vanished */
    DAVAR_HEALTH_LINK_BACK,          /**< link: times it came back */
    DAVAR_HEALTH_NOISE_BYTES,        /**< link: bytes received on the serial line and ignored */
    DAVAR_HEALTH_EDGES_LOST,         /**< source: data-ready edges that were not read */
    DAVAR_HEALTH_SOURCE_FAULTS,      /**< source: samples that could not be read */
    DAVAR_HEALTH_ALARMS,             /**< monitor: times its alarm was raised */
    DAVAR_HEALTH_WINDOW_CUTS,        /**< law glr: windows cut */
    DAVAR_HEALTH_NOISE_ALARMS,       /**< law glr: alarms raised */
    DAVAR_HEALTH_SHOCKS_LEFT_OUT,    /**< law glr: shocks treated as gaps */
    DAVAR_HEALTH_COUNT               /**< number of counters */
} davar_health_item_t;

/** The counters of one channel. The sender owns and updates them. */
typedef struct {
    uint32_t count[DAVAR_HEALTH_COUNT]; /**< by davar_health_item_t */
} davar_can_health_t;

/** Copies the counters of an instance (davar_health) to *frames. The counters of link, source and
 * monitor keep their values. Cost: O(1). */
void davar_can_health(davar_can_health_t *frames, const davar_health_t *health);

/** Item of DAVAR_Setup. The cluster size of tau i is item DAVAR_SETUP_TAU + i. */
typedef enum {
    DAVAR_SETUP_RATE = 0,   /**< sample rate, Hz */
    DAVAR_SETUP_STRIDE = 1, /**< stride, samples */
    DAVAR_SETUP_UNIT = 2,   /**< size of a count; sent with content DAVAR_SEND_RAW */
    DAVAR_SETUP_TAU = 32    /**< cluster size of the first tau, samples */
} davar_setup_item_t;

/** Form of DAVAR_Raw: the type of its samples. */
typedef enum {
    DAVAR_RAW_PAIR = 0,  /**< two counts of 16 bits from consecutive samples */
    DAVAR_RAW_COUNT = 1, /**< one count of 32 bits */
    DAVAR_RAW_RATE = 2   /**< one float32, deg/s */
} davar_raw_form_t;

/** Item of DAVAR_Change (law glr). Every item carries the alarm. Every result has item CUT: age of
 * the cut and dispersion. Content DAVAR_SEND_ADEV or DAVAR_SEND_FD adds the others. */
typedef enum {
    DAVAR_CHANGE_CUT = 0, /**< age of the cut, samples, and dispersion */
    DAVAR_CHANGE_OLDER,   /**< deg/s, as in davar_change_t */
    DAVAR_CHANGE_NEWER,   /**< deg/s, as in davar_change_t */
    DAVAR_CHANGE_GAIN,    /**< as in davar_change_t */
    DAVAR_CHANGE_COUNT    /**< number of items */
} davar_change_item_t;

/** Item of DAVAR_Monitor: health; below it, the deviation of that tau. */
#define DAVAR_MONITOR_HEALTH 32U
#define DAVAR_MONITOR_NO_TAU 255U /**< WorstTau if nothing was compared */
#define DAVAR_FLOOR_HIGH 2U /**< FloorKind of the upper limit; 0: the floor, 1: its lower limit */

/** @name Optional frames of a result
 * Their sum is `content` of davar_encoder_init. DAVAR_Arw, DAVAR_State, DAVAR_Stationarity,
 * DAVAR_End, DAVAR_Health and DAVAR_Setup are always sent. @{ */
#define DAVAR_SEND_ADEV 1U         /**< one frame per tau; law glr: the levels of a change too */
#define DAVAR_SEND_COEFFICIENTS 2U /**< five frames */
#define DAVAR_SEND_INTERVALS 4U    /**< ten more: the 95 % limits of the coefficients */
/** one 64-byte frame replaces all of these; DAVAR_Adev from the ninth tau on */
#define DAVAR_SEND_FD 8U
/** one frame per tau and one for health, after davar_encoder_monitor */
#define DAVAR_SEND_MONITOR 16U
#define DAVAR_SEND_RAW 32U /**< DAVAR_Setup includes the size of a count; see davar_encoder_raw */
/** @} */

/** One frame. */
typedef struct {
    uint16_t identifier; /**< standard, 11 bit */
    uint8_t length;      /**< 8, or 64 for CAN FD */
    uint8_t data[64];    /**< the first `length` bytes count */
} davar_frame_t;

/** An encoder of one channel, about 130 bytes. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    const davar_config_t *config;
    const davar_result_t *result;
    const davar_glr_report_t *report;
    const davar_can_health_t *health;
    const davar_misfit_t *misfit;
    const davar_floor_result_t *floor;
    uint32_t told[DAVAR_HEALTH_COUNT]; /* health counters as last sent */
    uint16_t base;
    uint8_t content;
    uint8_t stage;
    uint8_t index;  /* within the stage */
    uint8_t tag;    /* Counter of this result's DAVAR_State (or DAVAR_ResultFd) */
    uint8_t frames; /* of this result so far */
    uint8_t session;
    uint8_t health_next;
    uint8_t setup_next;
    uint8_t counter[DAVAR_MESSAGE_COUNT]; /* of the next frame of each message */
    bool raw_held;                        /* a count is waiting for the next one, to form a pair */
    int32_t raw_count;
    uint32_t raw_index;
    uint32_t digest; /* sum over `frames` */
} davar_encoder_t;

/** Starts an encoder.
 * `config` is the configuration of the instance and must outlive the encoder. `base` is the
 * identifier of channel 0, `content` a sum of DAVAR_SEND_*.
 * @return False, with *encoder unchanged, if the identifiers of the channel exceed 11 bits.
 *
 * Cost: O(1). */
DAVAR_NODISCARD bool davar_encoder_init(davar_encoder_t *encoder, const davar_config_t *config,
                                        uint16_t base, uint8_t channel, uint8_t content);

/** Starts the frames of one result.
 * *report comes from davar_glr_report. DAVAR_Change is sent only with law glr and a report, which
 * may be null. The encoder reads *result, *report and *health until davar_encoder_next returns
 * false; do not change them before. A NaN, a magnitude above DAVAR_CAN_MOST or an unexpected
 * negative number is sent as absent, a magnitude below DAVAR_CAN_LEAST as 0, an upper limit above
 * DAVAR_CAN_MOST as infinity. Cost: O(1). */
void davar_encoder_begin(davar_encoder_t *encoder, const davar_result_t *result,
                         const davar_glr_report_t *report, const davar_can_health_t *health);

/** Adds *misfit to every following result (content DAVAR_SEND_MONITOR); null stops that.
 * The encoder reads it between davar_encoder_begin and the last frame of the result; the caller
 * keeps it up to date. Call it after davar_encoder_init. Cost: O(1). */
void davar_encoder_monitor(davar_encoder_t *encoder, const davar_misfit_t *misfit);

/** Adds *floor, the newest result of davar_floor_take, to every following result: three frames, with
 * every content; null stops that. The encoder reads it as it does *misfit. Call it after
 * davar_encoder_init. Cost: O(1). */
void davar_encoder_floor(davar_encoder_t *encoder, const davar_floor_result_t *floor);

/** Sets the session number, which distinguishes a restart of the sender from lost frames.
 * Use a different number for each run: a boot counter, a clock or noise. With 0, the default, a
 * receiver detects a restart only if the epoch falls back. Call it after davar_encoder_init.
 * Cost: O(1). */
void davar_encoder_session(davar_encoder_t *encoder, uint8_t session);

/** Starts the frames of the end: every health counter once more, so that the last loss is reported.
 * Cost: O(1). */
void davar_encoder_finish(davar_encoder_t *encoder, const davar_can_health_t *health);

/** Writes the next frame.
 * @return False if none is left; *frame is then unchanged. A frame counts as sent: if the caller
 *         drops it, Counter has a hole at the receiver.
 *
 * Cost: O(length). */
bool davar_encoder_next(davar_encoder_t *encoder, davar_frame_t *frame);

/** Encodes one raw sample, for diagnosis at the receiver. Call it at any time between frames.
 * `index` counts samples from 0, missing ones included (unlike Epoch); 18 bits are sent. Counts
 * within 16 bits are sent in pairs, one frame every second sample. A wider count, or one before a
 * gap, has its own frame.
 * @return True if *frame must be sent. Cost: O(1). */
bool davar_encoder_raw(davar_encoder_t *encoder, uint64_t index, int32_t count,
                       davar_frame_t *frame);

/** Encodes the count that is still waiting for its pair, at the end of a stream.
 * @return True if *frame must be sent. Cost: O(1). */
bool davar_encoder_raw_rest(davar_encoder_t *encoder, davar_frame_t *frame);

/** Encodes one sample of a float instance: one frame per sample, in deg/s. A value that is not
 * finite is sent as NaN. Cost: O(1). */
void davar_encoder_raw_f32(davar_encoder_t *encoder, uint64_t index, float rate_dps,
                           davar_frame_t *frame);

/** Returns the CRC-8/SAE-J1850 of a frame: polynomial 0x1D, initial value and final xor 0xFF, over the
 * identifier (low byte, high byte) and the data from byte 1 on. Cost: O(length). */
uint8_t davar_frame_crc(const davar_frame_t *frame);

/** Returns the 32-bit FNV-1a of the same bytes (initial value 0x811C9DC5, factor 0x01000193).
 * The sum over the frames of a result, modulo 2^32 and in any order, is Digest of its DAVAR_End.
 * DAVAR_End itself, DAVAR_Health, DAVAR_Setup and DAVAR_Raw do not count. Cost: O(length). */
uint32_t davar_frame_digest(const davar_frame_t *frame);

#ifdef __cplusplus
}
#endif

#endif
