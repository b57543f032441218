/* davar - results on a CAN bus or a serial line: result -> frames -> values.
 * The layout is written for people in lib/WIRE.md and for tools in tools/davar.dbc; a test holds both and this codec
 * together bit for bit. No heap, no I/O, no floating-point division: small enough for a Cortex-M0.
 *
 * Sender:   davar_encoder_init, then per result davar_encoder_begin and davar_encoder_next until it returns false;
 *           per sample davar_encoder_raw, where somebody wants to diagnose the sensor from afar.
 * Receiver: davar_decode per frame; then the frames with one Result are one result if their number and the sum of their
 *           davar_frame_digest are those of its DAVAR_End. Otherwise a frame is lost or is another result's: drop them.
 * An encoder belongs to one thread. Nothing here blocks. */
#ifndef DAVAR_CODEC_H
#define DAVAR_CODEC_H

#include "davar/monitor.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_WIRE_BASE 0x5D0U    /* default identifier of channel 0; standard 11 bit */
#define DAVAR_WIRE_STEP 16U       /* identifiers per channel */
#define DAVAR_WIRE_LAST_ID 0x7FFU /* of a standard frame */
#define DAVAR_FD_TAUS 8U          /* Allan deviations inside DAVAR_ResultFd */
#define DAVAR_WIRE_LEAST 1e-30F   /* magnitude of any float on the wire, but 0 */
#define DAVAR_WIRE_MOST 1e30F

/* Message of a channel: identifier = base + 16 channel + message. */
typedef enum {
    DAVAR_MESSAGE_ARW = 0,
    DAVAR_MESSAGE_STATE = 1,
    DAVAR_MESSAGE_STATIONARITY = 2,
    DAVAR_MESSAGE_ADEV = 3,
    DAVAR_MESSAGE_COEFFICIENT = 4,
    DAVAR_MESSAGE_HEALTH = 5,
    DAVAR_MESSAGE_SETUP = 6,
    DAVAR_MESSAGE_MONITOR = 7,
    DAVAR_MESSAGE_RESULT_FD = 8,
    DAVAR_MESSAGE_RAW = 9,
    DAVAR_MESSAGE_CHANGE = 10,
    DAVAR_MESSAGE_END = 11,
    DAVAR_MESSAGE_COUNT = 12
} davar_message_t;

/* Everything that can be lost has a counter here; DAVAR_Health carries them one by one. */
typedef enum {
    DAVAR_HEALTH_GAPS = 0,          /* davar_health_t of the channel: the first six, and the last three */
    DAVAR_HEALTH_MISSING_SAMPLES,   /* samples */
    DAVAR_HEALTH_SATURATED_SAMPLES, /* samples */
    DAVAR_HEALTH_NOT_FINITE_SAMPLES,
    DAVAR_HEALTH_WINDOW_RESTARTS,
    DAVAR_HEALTH_RESULTS_MISSED,
    DAVAR_HEALTH_FRAMES_DROPPED, /* the link: encoded, and never sent */
    DAVAR_HEALTH_SEND_RETRIES,   /* times the link had no room */
    DAVAR_HEALTH_ERROR_PASSIVE,  /* times the bus became error passive */
    DAVAR_HEALTH_BUS_OFF,        /* times it went off */
    DAVAR_HEALTH_LINK_LOST,      /* times interface or serial peer vanished */
    DAVAR_HEALTH_LINK_BACK,      /* times it came back */
    DAVAR_HEALTH_NOISE_BYTES,    /* received on the serial line, and ignored */
    DAVAR_HEALTH_EDGES_LOST,     /* the source: data-ready edges that nobody read */
    DAVAR_HEALTH_SOURCE_FAULTS,  /* samples that could not be read */
    DAVAR_HEALTH_ALARMS,         /* times the alarm rose */
    DAVAR_HEALTH_WINDOW_CUTS,    /* policy glr, davar_health_t of the channel: */
    DAVAR_HEALTH_NOISE_ALARMS,
    DAVAR_HEALTH_SHOCKS,
    DAVAR_HEALTH_COUNT
} davar_health_item_t;

typedef struct {
    uint32_t count[DAVAR_HEALTH_COUNT];
} davar_wire_health_t;

/* Item of DAVAR_Setup: rate, stride, size of a count (content DAVAR_SEND_RAW), then cluster size of tau i as
 * DAVAR_SETUP_TAU + i. */
typedef enum {
    DAVAR_SETUP_RATE = 0,
    DAVAR_SETUP_STRIDE = 1,
    DAVAR_SETUP_UNIT = 2,
    DAVAR_SETUP_TAU = 32
} davar_setup_item_t;

/* Form of DAVAR_Raw: what its samples are. */
typedef enum {
    DAVAR_RAW_PAIR = 0,  /* two counts of 16 bits, one sample after the other */
    DAVAR_RAW_COUNT = 1, /* a count of 32 bits */
    DAVAR_RAW_RATE = 2   /* a float32, deg/s */
} davar_raw_form_t;

/* Item of DAVAR_Change (policy glr): age of the cut and dispersion, with every result; with content DAVAR_SEND_ADEV or
 * DAVAR_SEND_FD also the levels of the newest change and its gain. All of them say whether there is an alarm. */
typedef enum {
    DAVAR_CHANGE_CUT = 0,
    DAVAR_CHANGE_OLDER, /* deg/s, as in davar_change_t */
    DAVAR_CHANGE_NEWER,
    DAVAR_CHANGE_GAIN,
    DAVAR_CHANGE_COUNT
} davar_change_item_t;

/* Item of DAVAR_Monitor: the deviation of tau i as i, then the health number. */
#define DAVAR_MONITOR_HEALTH 32U
#define DAVAR_MONITOR_NO_TAU 255U /* WorstTau when nothing was compared */

/* Optional frames of a result; DAVAR_Arw, DAVAR_State, DAVAR_Stationarity, DAVAR_End, DAVAR_Health and DAVAR_Setup always go. */
#define DAVAR_SEND_ADEV 1U         /* one frame per tau */
#define DAVAR_SEND_COEFFICIENTS 2U /* five frames */
#define DAVAR_SEND_INTERVALS 4U    /* ten more: 95 % limits of the coefficients */
#define DAVAR_SEND_FD 8U           /* one 64-byte frame instead of all of these (taus from the ninth on: DAVAR_Adev) */
#define DAVAR_SEND_MONITOR 16U     /* one frame per tau and one for health, once davar_encoder_monitor was called */
#define DAVAR_SEND_RAW 32U         /* DAVAR_Setup tells the size of a count; samples go by davar_encoder_raw */

/* One frame. length is 8, or 64 for CAN FD. */
typedef struct {
    uint16_t identifier;
    uint8_t length;
    uint8_t data[64];
} davar_frame_t;

/* Belongs to the caller; begin with davar_encoder_init. Fields are private. About 130 bytes. */
typedef struct {
    const davar_config_t *config;
    const davar_result_t *result;
    const davar_wire_health_t *health;
    const davar_misfit_t *misfit;
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
    bool raw_held;                        /* a count waits for the next one, to go as a pair */
    int32_t raw_count;
    uint32_t raw_index;
    uint32_t digest; /* sum over `frames` */
} davar_encoder_t;

/* Starts an encoder: `config` is the one of the instance (must outlive the encoder), `base` the identifier of channel
 * 0, `content` a sum of DAVAR_SEND_*. False: the channel's identifiers do not fit into 11 bits; nothing is touched. */
bool davar_encoder_init(davar_encoder_t *encoder, const davar_config_t *config, uint16_t base, uint8_t channel,
                        uint8_t content);

/* Begins the frames of one result. `result` and `health` must stay valid and unchanged until davar_encoder_next has
 * returned false. A negative number (but a deviation from a model), NaN or a magnitude above DAVAR_WIRE_MOST goes out as absent, a magnitude
 * below DAVAR_WIRE_LEAST as 0, an upper limit above DAVAR_WIRE_MOST as infinity. O(1). */
void davar_encoder_begin(davar_encoder_t *encoder, const davar_result_t *result, const davar_wire_health_t *health);

/* Sends *misfit with every result from now on (content DAVAR_SEND_MONITOR), null: no more. The caller keeps it up to date: it
 * is read between davar_encoder_begin and the end of the result. Call after davar_encoder_init. */
void davar_encoder_monitor(davar_encoder_t *encoder, const davar_misfit_t *misfit);

/* Which run of the sender this is: another number than last time (a boot counter, a clock, noise), so that a receiver can tell
 * a restart from lost frames whatever it missed. 0 (the default): not told; a restart then shows in an epoch that falls
 * back. Call after davar_encoder_init. */
void davar_encoder_session(davar_encoder_t *encoder, uint8_t session);

/* Begins the farewell: every health counter once more, so that the last loss is told too. */
void davar_encoder_finish(davar_encoder_t *encoder, const davar_wire_health_t *health);

/* Writes the next frame; false: there is none. A frame counts as sent: whoever drops it leaves a hole in Counter, which
 * the receiver sees. O(length). */
bool davar_encoder_next(davar_encoder_t *encoder, davar_frame_t *frame);

/* Raw samples, for who diagnoses the sensor at the other end: off unless called, at any time between frames. `index` is that
 * of the sample, from 0, what is missing counted (unlike in Epoch; 18 bits go out). Counts within 16 bits go in pairs, so that a
 * frame is due every second sample; a wider one, or one in front of a gap, has a frame of its own. True: send *frame. At the
 * end davar_encoder_raw_rest gives the count that waits for its neighbour, if one does. O(1). */
bool davar_encoder_raw(davar_encoder_t *encoder, uint64_t index, int32_t count, davar_frame_t *frame);
bool davar_encoder_raw_rest(davar_encoder_t *encoder, davar_frame_t *frame);

/* The same for a float instance: one sample a frame, in deg/s. What is not finite goes out as NaN. */
void davar_encoder_raw_f32(davar_encoder_t *encoder, uint64_t index, float rate_dps, davar_frame_t *frame);

typedef enum {
    DAVAR_DECODED = 0,
    DAVAR_DECODE_FOREIGN, /* not an identifier of this base */
    DAVAR_DECODE_LENGTH,  /* not the length of this message */
    DAVAR_DECODE_CRC,     /* damaged */
    DAVAR_DECODE_VALUE    /* an index or a value that no sender means: damage that passed the checksum */
} davar_decode_status_t;

/* What one frame says. Absent values are NaN. Units as in davar_result_t. */
typedef struct {
    davar_message_t message;
    uint8_t channel;
    uint8_t counter; /* Counter, 0..15 */
    uint8_t result;  /* Result: Counter of the DAVAR_State it belongs to, 0..15; not in State, ResultFd, Raw */
    uint8_t session; /* DAVAR_End, DAVAR_Health, DAVAR_Setup: davar_encoder_session */
    uint8_t
        index; /* TauIndex; Kind (coefficient + 5 for low, + 10 for high); HealthIndex; Item; MonitorIndex; Form; ChangeItem; Frames */
    float value; /* the float32 of the message; in DAVAR_ResultFd ARW */
    uint32_t
        number; /* Epoch (24 bits in DAVAR_ResultFd), health count, stride, cluster size, Index (18 bits), Digest */
    int32_t count[2]; /* DAVAR_Raw: the counts from sample `number` on; two of a pair, one of DAVAR_RAW_COUNT */
    uint32_t window_samples;
    bool unstable;
    float relative_uncertainty; /* of ARW or of the Allan deviation: half the 95 % interval over the value */
    uint8_t worst; /* DAVAR_Monitor, health: index of the tau that decides it; DAVAR_MONITOR_NO_TAU: none */
    float kurtosis;
    float contribution;
    bool alarm; /* DAVAR_Change: as in davar_result_t, */
    bool young;
    uint32_t change_m;
    uint32_t cut_age_samples;                   /* item DAVAR_CHANGE_CUT only: 2^20 - 1: that or more */
    float dispersion;                           /* likewise */
    float adev[DAVAR_FD_TAUS];                  /* DAVAR_ResultFd */
    float coefficient[DAVAR_COEFFICIENT_COUNT]; /* DAVAR_ResultFd */
} davar_wire_t;

/* Reads one frame; *wire is filled when the answer is DAVAR_DECODED. A value that cannot be is refused: a deviation or
 * coefficient below 0, infinite (but for an upper limit) or outside DAVAR_WIRE_LEAST .. DAVAR_WIRE_MOST, a rate of 0, a
 * window, stride, cluster size or number of frames of 0. O(length). */
davar_decode_status_t davar_decode(const davar_frame_t *frame, uint16_t base, davar_wire_t *wire);

/* CRC-8/SAE-J1850 (polynomial 0x1D, start and final xor 0xFF) of identifier (low byte, high byte) and data from byte 1
 * on. O(length). */
uint8_t davar_frame_crc(const davar_frame_t *frame);

/* FNV-1a of 32 bits (start 0x811C9DC5, factor 0x01000193) of the same bytes. The sum over the frames of a result, in any order
 * and modulo 2^32, is Digest of its DAVAR_End. Not counted: DAVAR_End itself, DAVAR_Health, DAVAR_Setup,
 * DAVAR_Raw. O(length). */
uint32_t davar_frame_digest(const davar_frame_t *frame);

#ifdef __cplusplus
}
#endif

#endif
