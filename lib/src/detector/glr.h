/* davar - when did the noise change? A scan of the likelihood ratio of one variance against two, at split points of dyadic ages,
 * with two thresholds: a cheap one cuts the window, a strict one raises the alarm. Blocks come in, decisions go out; integers
 * only, the same on every target.
 *
 *      blocks  0                                  at
 *              |--------------|----------|xxxxxxx|..|     records of the running sum of ages 2 to 5 blocks and, in turn,
 *                             alarm      cut   split       6, 10; 12, 20; ..; each scan compares [cut, split) with [split, at)
 */
#ifndef DAVAR_SRC_GLR_H
#define DAVAR_SRC_GLR_H

#include "davar/law.h"
#include "detector/spread.h"

#define GAIN_DIGITS                                                                                \
    12U /* binary, behind the point, of a likelihood ratio and of what it is compared with */

/* --- dispersion -------------------------------------------------------------------------------------------------- */

/* How much wider than Gaussian noise's the blocks scatter: heavy tails and correlated noise widen the thresholds of the
 * detector instead of alarming for ever. */

/* phi: mean square of the steps of ln b, over that of chi-squares. 24 digits: 1 is Gaussian. */
typedef struct {
    uint32_t phi;
    int32_t before; /* ln of the block before */
    uint32_t count; /* blocks so far, up to where the mean begins to forget */
} davar_dispersion_t;

void davar_dispersion_start(davar_dispersion_t *dispersion);

/* The next ln b. `unit` is 1 over the mean square step of a chi-square's logarithm, 16 digits; the mean forgets over 2^memory
 * blocks. */
void davar_dispersion_learn(davar_dispersion_t *dispersion, int32_t logarithm, uint32_t unit,
                            uint32_t memory);

/* --- the detector ------------------------------------------------------------------------------------------------ */

#define GLR_LEVELS 9U    /* octaves of ages */
#define GLR_RECORDS 4U   /* of one octave */
#define GLR_SHOCK_MAX 2U /* blocks that a shock may last */
#define GLR_LONGEST 768U /* blocks of a window: 3 * 2^8 */
#define GLR_BLOCK_MIN 5U /* samples of a block */
#define GLR_BLOCK_MAX 64U
#define GLR_RECENT 64U       /* blocks that are remembered one by one */
#define GLR_CUTS 5U          /* remembered, the oldest of them a bound */
#define GLR_CLUSTER_MAX 512U /* samples of a cluster of the second channel */
#define GLR_HALF_MAX                                                                               \
    30U /* blocks of half a centred window: twice this and GLR_CUTS - 1 are at most GLR_RECENT */

/* What davar_glr_start() makes of a rate of false alarms; digits are binary, behind the point. */
typedef struct {
    uint32_t block;     /* K, samples */
    uint32_t degrees;   /* nu = K - 1; 8 digits */
    uint32_t floor;     /* b of rounding alone: K nu */
    uint32_t least;     /* blocks that each part of a split must hold */
    uint32_t longest;   /* blocks, of a window */
    uint32_t levels;    /* 1..GLR_LEVELS, so that 3 * 2^(levels - 1) >= longest */
    uint32_t shock;     /* blocks that are dropped as a shock, 0..GLR_SHOCK_MAX; 0: none ever */
    uint32_t outlier;   /* times the mean block: what may begin a shock, 8 digits */
    uint32_t alarm;     /* h of the alarm, 16 digits */
    uint32_t cut;       /* h of the window's cut, 16 digits, not above the alarm's */
    uint32_t step;      /* 1 / mean square step of ln b (Gaussian noise), 16 digits */
    uint32_t step_of_8; /* the same for the sums of eight blocks */
    uint32_t bias;      /* 1 / (3 nu), 16 digits */
    uint32_t
        near; /* blocks at least, of a trailing window, when there are so many since its cut: 150 samples */
    uint32_t far;  /* blocks from which on a window grows by the stricter rule: 600 samples */
    uint32_t half; /* blocks of half a centred window: 300 samples; 0: cuts are not remembered */
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

/* No pointers: saved and restored as bytes. */
typedef struct {
    davar_spread_t
        record[GLR_LEVELS]
              [GLR_RECORDS]; /* of the running sum at k, where 2^level divides k: [k >> level] */
    davar_spread_t waiting[GLR_SHOCK_MAX]; /* blocks that may be a shock: not in any sum yet */
    davar_spread_t eight;                  /* sum of up to eight blocks, for the dispersion */
    davar_glr_place_t now;   /* end of the accepted blocks, the dropped ones counted */
    davar_glr_place_t alarm; /* beginnings of the stretches that are held to be of one variance */
    davar_glr_place_t cut;   /* never older */
    davar_dispersion_t single;
    davar_dispersion_t of_8;
    davar_glr_place_t past
        [GLR_CUTS]; /* cuts, the oldest first; at the start the beginning of the stream is one */
    uint16_t recent
        [GLR_RECENT]; /* block k at k % GLR_RECENT: 7 bits of exponent, 9 of mantissa; 0: dropped */
    uint32_t counts;  /* bit i: that cut is a step, not part of a ramp */
    uint32_t settled; /* ... for ever */
    uint8_t cuts;
    uint8_t turn;    /* of which cut to judge next */
    uint8_t seen;    /* blocks since the beginning, up to GLR_HALF_MAX */
    uint8_t pending; /* blocks that wait */
} davar_glr_t;

/* What a block brought about. */
typedef struct {
    bool is_cut;          /* the window begins anew at state->cut */
    bool is_alarm;        /* the noise has changed: */
    davar_spread_t older; /* from what */
    davar_spread_t newer; /* to what */
    int32_t gain;         /* G of that split, GAIN_DIGITS */
    uint32_t resolved;    /* blocks by which state->now has moved; 0 while a shock is possible */
    uint32_t dropped;     /* how many of them, the first ones, were a shock */
} davar_glr_event_t;

/* What a user states. */
typedef struct {
    double rate_hz;
    double false_alarms_per_hour; /* above 0 */
    double cut_interval_s;        /* between two cuts of a window that needed none */
    uint32_t longest;             /* samples of a window, at least 8 blocks, at most GLR_LONGEST */
    uint32_t block;               /* K: 5..GLR_BLOCK_MAX samples; 10 or 25 were measured */
    uint32_t shock;               /* blocks, 0..GLR_SHOCK_MAX; 0: shocks are changes as any other */
    bool is_centred;              /* cuts are remembered and judged */
} davar_glr_wish_t;

/* Thresholds and constants for these rates; every rate is a positive finite number. */
void davar_glr_start(davar_glr_config_t *config, const davar_glr_wish_t *wish);

/* The same for the second channel, whose blocks are b = 6 D^2 + m, D the difference of two clusters of m = 4 wish->block samples that
 * follow one another, once for every wish->block samples. It cuts where it alarms; `longest` counts these blocks. */
void davar_glr_start_clusters(davar_glr_config_t *config, const davar_glr_wish_t *wish);

void davar_glr_reset(davar_glr_t *state);

/* What was is over, as at an alarm. */
void davar_glr_begin_anew(davar_glr_t *state);

/* The next block of K samples: their sum, and the sum of their squares. O(levels), and at most five splits for each threshold. */
void davar_glr_push_q15(davar_glr_t *state, const davar_glr_config_t *config, int32_t sum,
                        uint64_t squares, davar_glr_event_t *event);
void davar_glr_push_q31(davar_glr_t *state, const davar_glr_config_t *config, int64_t sum,
                        const davar_u128_t *squares, davar_glr_event_t *event);

/* For davar_glr_start_clusters(): D of two clusters of samples, counts. */
void davar_glr_push_clusters_q15(davar_glr_t *state, const davar_glr_config_t *config,
                                 int32_t difference, davar_glr_event_t *event);
void davar_glr_push_clusters_q31(davar_glr_t *state, const davar_glr_config_t *config,
                                 int64_t difference, davar_glr_event_t *event);

/* The same with b itself, which is not 0. */
void davar_glr_push(davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_spread_t *block, davar_glr_event_t *event);

/* A block with a gap in it: it takes its time and belongs to no sum. What waited is dropped with it. */
void davar_glr_skip(davar_glr_t *state, const davar_glr_config_t *config, davar_glr_event_t *event);

/* f, at least 1: by how much the thresholds are widened. GAIN_DIGITS. */
uint32_t davar_glr_dispersion(const davar_glr_t *state);

/* --- windows ----------------------------------------------------------------------------------------------------- */

/* Which window follows from the cuts: as long as the likelihood ratio finds one variance in it. */

/* Blocks [begin, end), modulo 2^32, as davar_glr_place_t counts them. */
typedef struct {
    uint32_t begin;
    uint32_t end;
    uint32_t blocks; /* of them that were accepted */
    uint32_t after;  /* accepted behind the end */
} davar_glr_window_t;

/* The window that ends with the newest accepted block. At most ten tests, six with 600 blocks; nearly always no logarithm. */
void davar_glr_trailing(const davar_glr_t *state, const davar_glr_config_t *config,
                        davar_glr_window_t *window);

/* The window about the place `age` blocks before that. False, and the blocks there are, while none was there. O(GLR_RECENT). */
bool davar_glr_centred(const davar_glr_t *state, const davar_glr_config_t *config, uint32_t age,
                       davar_glr_window_t *window);

/* How many blocks ago so many accepted ones began, GLR_RECENT at most. */
uint32_t davar_glr_age_of(const davar_glr_t *state, uint32_t accepted);

/* For glr.c: no cut but the beginning; the next block, before now counts it; after each block, is there a new cut, and the turn
 * of one cut to be judged. */
void davar_glr_forget(davar_glr_t *state);
void davar_glr_remember(davar_glr_t *state, const davar_spread_t *block);
void davar_glr_note(davar_glr_t *state, const davar_glr_config_t *config, bool is_cut);

/* --- the window law, for both number types ------------------------------------------------------------------------ */

/* What is read of the detector for a result (law.h). */
typedef struct {
    davar_spread_t older; /* before the newest change that was reported */
    davar_spread_t newer;
    uint32_t changed; /* cluster that changed, samples; 0: none did */
    int32_t gain;
    uint32_t dispersion; /* f, GAIN_DIGITS */
} davar_glr_words_t;

/* Root of (sum - blocks * floor) / (blocks * unit), to 32 bits; floor is what rounding adds to each block. At least one block. */
double davar_spread_level(const davar_spread_t *sum, uint32_t floor, uint32_t unit);

davar_status_t davar_glr_check(const davar_config_t *config);
void davar_glr_shape(const davar_config_t *config, davar_law_shape_t *shape);
void davar_glr_put(davar_law_words_t *words, const davar_glr_words_t *read);
void davar_glr_report(const davar_config_t *config, double unit_per_count,
                      const davar_law_words_t *words, davar_result_t *result);

#endif
