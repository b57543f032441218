/* davar - the detector: finds when the noise changed. It scans the likelihood ratio of one variance
 * against two at split points of dyadic ages. A low threshold cuts the window, a high one raises
 * the alarm. Integers only, the same on every target.
 *
 *      blocks  0                                  at
 *              |--------------|----------|xxxxxxx|..|
 *                             alarm      cut   split
 *
 * The running sum is recorded at ages of 2 to 5 blocks and, in turn, 6, 10; 12, 20; ... A scan
 * compares [cut, split) with [split, at). */
#ifndef DAVAR_SRC_GLR_H
#define DAVAR_SRC_GLR_H

#include "core/law.h"
#include "laws/spread.h"

#define GAIN_DIGITS 12U /* binary, after the point, of a likelihood ratio and of its limits */
#define F_ONE (UINT32_C(1) << GAIN_DIGITS)

/* --- dispersion ------------------------------------------------------------------------------- */

/* How much more the blocks scatter than in Gaussian noise. Heavy tails and correlated noise
 * widen the thresholds by it; otherwise they would alarm all the time. */
typedef struct {
    uint32_t
        phi; /* mean square step of ln b over that of chi-squares, 24 digits; Gaussian noise: 1 */
    int32_t before; /* ln of the previous block */
    uint32_t count; /* blocks so far, up to the number from which the mean forgets */
} davar_dispersion_t;

void davar_dispersion_start(davar_dispersion_t *dispersion);

/* The next ln b. `unit` is 1 over the mean square step of the logarithm of a chi-square, 16 digits;
 * the mean forgets over 2^memory blocks. */
void davar_dispersion_learn(davar_dispersion_t *dispersion, int32_t logarithm, uint32_t unit,
                            uint32_t memory);

/* --- the detector ----------------------------------------------------------------------------- */

#define GLR_LEVELS 9U         /* octaves of ages */
#define GLR_RECORDS 4U        /* of one octave */
#define GLR_SHOCK_MAX 2U      /* blocks of the longest shock */
#define GLR_LONGEST 768U      /* blocks of a window: 3 * 2^8 */
#define GLR_BLOCK_MIN 5U      /* samples of a block */
#define GLR_BLOCK_MAX 64U     /* samples of a block */
#define GLR_WHITEN_MAX 49152U /* |first| + |second|: 3, 14 digits */

/* Thresholds and constants. "n digits": n binary digits after the point. */
typedef struct {
    uint32_t block;     /* K, samples */
    uint32_t degrees;   /* nu = K - 1 */
    uint32_t floor;     /* b of rounding alone: K nu, more with whitening (10.17) */
    uint32_t longest;   /* blocks of a window */
    uint32_t levels;    /* 1..GLR_LEVELS, so that 3 * 2^(levels - 1) >= longest */
    uint32_t shock;     /* blocks that may be dropped as a shock, 0..GLR_SHOCK_MAX; 0: never */
    uint32_t outlier;   /* a block this many times the mean may begin a shock, 8 digits */
    uint32_t alarm;     /* threshold h of the alarm, 16 digits */
    uint32_t cut;       /* threshold h of the cut, 16 digits; at most that of the alarm */
    uint32_t step;      /* 1 / mean square step of ln b in Gaussian noise, 16 digits */
    uint32_t step_of_8; /* the same for sums of eight blocks */
    uint32_t bias;      /* 1 / (3 nu), 16 digits */
    uint32_t near;      /* least blocks of a window, once its cut is older: 150 samples */
    uint32_t far;       /* a window above this grows by the stricter rule, blocks: 600 samples */
} davar_glr_config_t;

/* A place in the stream and the running sum there. */
typedef struct {
    davar_spread_t sum;
    uint32_t at; /* blocks, modulo 2^32 */
} davar_glr_place_t;

static inline void glr_place_copy(davar_glr_place_t *to, const davar_glr_place_t *from)
{
    spread_copy(&to->sum, &from->sum);
    to->at = from->at;
}

/* Hazard: saved and restored as bytes, so it holds no pointers. */
typedef struct {
    davar_spread_t record[GLR_LEVELS][GLR_RECORDS]; /* running sum at k: [level][k >> level], k a
                                                       multiple of 2^level */
    davar_spread_t waiting[GLR_SHOCK_MAX];          /* blocks that may be a shock; in no sum yet */
    davar_spread_t eight;    /* sum of up to eight blocks, for the dispersion */
    davar_glr_place_t now;   /* end of the accepted blocks; dropped ones count in `at` */
    davar_glr_place_t alarm; /* from here to now: no alarm */
    davar_glr_place_t cut;   /* from here to now: no cut; never older than `alarm` */
    davar_dispersion_t single;
    davar_dispersion_t of_8;
    uint8_t pending; /* blocks that wait */
} davar_glr_t;

/* The effect of a block. */
typedef struct {
    bool is_cut;          /* the window now begins at state->cut */
    bool is_alarm;        /* the noise has changed; only then are older and newer set */
    davar_spread_t older; /* sum before the change */
    davar_spread_t newer; /* sum after it */
    int32_t gain;         /* G of that split, GAIN_DIGITS; 0 without an alarm */
    uint32_t resolved;    /* blocks by which state->now has moved; 0 while a shock is possible */
    uint32_t dropped;     /* the first blocks of these, which were a shock */
    davar_spread_t shock; /* their sum; not set if none was dropped */
} davar_glr_event_t;

/* The settings of a user. */
typedef struct {
    double rate_hz;
    double false_alarms_per_hour; /* above 0 */
    double cut_interval_s;        /* between two unnecessary cuts of a window */
    uint32_t longest;             /* samples of a window, 8 to GLR_LONGEST blocks */
    uint32_t block;               /* K: 5..GLR_BLOCK_MAX samples; 10 or 25 were measured */
    uint32_t shock;               /* blocks, 0..GLR_SHOCK_MAX; 0: a shock is an ordinary change */
} davar_glr_wish_t;

/* Computes thresholds and constants; every rate is a positive finite number. */
void davar_glr_start(davar_glr_config_t *config, const davar_glr_wish_t *wish);

/* config->floor for whitened samples, b of rounding alone: K nu, and twice the rounding that
 * whitening adds, rounded (10.17). */
uint32_t davar_glr_floor(uint32_t block, int16_t first, int16_t second);

/* b of the rounding of the samples and, with whitening, of the predicted samples: exact for errors
 * of variance 1/12 that are independent (10.18). */
uint32_t davar_glr_rounding(uint32_t block, int16_t first, int16_t second);

void davar_glr_reset(davar_glr_t *state);

/* The next block of K samples: their sum and the sum of their squares. O(levels), and at most five
 * splits per threshold. */
void davar_glr_push_q15(davar_glr_t *state, const davar_glr_config_t *config, int32_t sum,
                        uint64_t squares, davar_glr_event_t *event);
void davar_glr_push_q31(davar_glr_t *state, const davar_glr_config_t *config, int64_t sum,
                        const davar_u128_t *squares, davar_glr_event_t *event);

/* Takes b directly; it is not 0. */
void davar_glr_push(davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_spread_t *block, davar_glr_event_t *event);

/* A block with a gap in it: its time passes, and no sum includes it. Waiting blocks are dropped
 * too. */
void davar_glr_skip(davar_glr_t *state, const davar_glr_config_t *config, davar_glr_event_t *event);

#define GLR_TYPICAL 3U /* octave of f = f(8): reported, and used everywhere but in the scan */
#define GLR_MANY 31U   /* octave above that of every split: the lower bound of f */

/* The factor f that widens the threshold of a split whose shorter part has 2^octave to
 * 2^(octave + 1) - 1 blocks: in heavy tails, sums of few blocks scatter more. octave: 0 to 31. At
 * least 1, below 16; GAIN_DIGITS. */
uint32_t davar_glr_dispersion(const davar_glr_t *state, uint32_t octave);

/* --- the window: as long as the likelihood ratio finds one variance in it ----------------------
 */

/* Where the window begins that ends with the newest accepted block. At most ten tests, six with 600
 * blocks; rarely a logarithm. */
void davar_glr_begin(const davar_glr_t *state, const davar_glr_config_t *config,
                     davar_glr_place_t *begin);

/* --- the level since the last alarm (10.18) --------------------------------------------------- */

typedef struct {
    davar_spread_t since;  /* running sum at its beginning */
    davar_spread_t middle; /* and at a place where half of it is compared with the rest */
    davar_spread_t shocks; /* blocks dropped since, except in gaps */
    uint16_t turn;         /* of the newest comparison, one every 2^6 blocks; modulo 2^16 */
    uint16_t wait;         /* turns until heavy tails no longer withhold the interval */
} davar_steady_sums_t;

/* Begins a section here. */
void davar_steady_restart(davar_steady_sums_t *steady, const davar_glr_t *detector);

/* The detector has taken a block. Begins a new section if the later part of this one is louder or
 * quieter than the earlier part, while tails are heavy, or after 2^30 blocks. */
void davar_steady_push(davar_steady_sums_t *steady, const davar_glr_t *detector,
                       const davar_glr_config_t *config, const davar_glr_event_t *event);

/* May the level of this section have an interval? Only if f is known, and tails have been light for
 * 2^14 blocks. */
bool davar_steady_is_known(const davar_steady_sums_t *steady, const davar_glr_t *detector);

/* --- the window law, for both number types ---------------------------------------------------- */

/* The law's state begins with it: all that a result and a report need, and nothing that depends on
 * the number type. */
typedef struct {
    davar_glr_t detector;
    davar_steady_sums_t steady; /* since the last alarm */
    davar_spread_t older;       /* before the newest reported change */
    int32_t gain;               /* of that change, GAIN_DIGITS */
    uint32_t age;               /* samples from the newest change to the newest epoch */
    uint32_t left_out;          /* samples dropped since the newest epoch */
    bool young;   /* of the newest epoch: the window was cut recently, or will be (10.14) */
    bool changed; /* an alarm has been reported */
} davar_glr_track_t;

/* What a report copies of it. */
typedef struct {
    davar_spread_t older; /* before the newest reported change */
    davar_spread_t newer; /* after it */
    int32_t gain;
    uint32_t dispersion;   /* f, GAIN_DIGITS */
    davar_spread_t steady; /* since the last alarm: accepted blocks */
    davar_spread_t shocks; /* and dropped ones */
    bool changed;
} davar_glr_copy_t;

/* Root of (sum - blocks * floor) / (blocks * unit), to 32 bits; rounding adds `floor` to each
 * block. At least one block. */
double davar_spread_level(const davar_spread_t *sum, uint32_t floor, uint32_t unit);

davar_status_t davar_glr_check(const davar_config_t *config);
uint32_t davar_glr_block(const davar_config_t *config);
void davar_glr_read(const void *state, davar_result_t *result);

/* Sets change and steady of an absent report. */
void davar_glr_evaluate(const davar_config_t *config, double unit_per_count,
                        const davar_glr_copy_t *copy, davar_glr_report_t *report);

#endif
