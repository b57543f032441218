/** @file
 * davar - floor: the noise of one gyro axis between rotor lines and motion, while the vehicle
 * moves.
 *
 * The floor is the mean density over the quietest quarter of the frequencies. White noise of the
 * sensor adds to it exactly, and so does broad vibration of the airframe: the floor is not the angle
 * random walk at rest, but the noise of the sensor is below its upper limit. docs/FLIGHT.md shows how to
 * use it; formulas: addons/floor/DESIGN.md (14.1) to (14.6).
 *
 * Arithmetic: IEEE float with + - * / and sqrt only, so every target computes the same bits. No
 * function allocates memory, blocks or reads a clock.
 *
 * Threads: a floor belongs to one thread or interrupt. A plan is constant and may be shared. */
#ifndef DAVAR_FLOOR_H
#define DAVAR_FLOOR_H

#include "davar/options.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_FLOOR_BINS 31U   /**< frequencies 1/64 to 31/64 of the sample rate */
#define DAVAR_FLOOR_BLOCKS 4U  /**< blocks of a window; a result follows each */
#define DAVAR_FLOOR_NEEDED 23U /**< usable frequencies, below which no value is present */
#define DAVAR_FLOOR_LIMITED 8U /**< ... and below which no limit is present either */

/** Why davar_floor_plan failed: one code per cause, with a value that never changes. */
typedef enum {
    DAVAR_FLOOR_OK = 0,        /**< no error */
    DAVAR_FLOOR_ERR_RATE = 1,  /**< rate_hz not positive and finite */
    DAVAR_FLOOR_ERR_UNIT = 2,  /**< unit_per_count not positive and finite */
    DAVAR_FLOOR_ERR_RAIL = 3,  /**< rail below 1 */
    DAVAR_FLOOR_ERR_BLOCK = 4, /**< block not 0 and not a multiple of 64 from 64 to 4096 */
    DAVAR_FLOOR_ERR_FILTER = 5 /**< a filter that is not valid */
} davar_floor_status_t;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_floor_status_text(davar_floor_status_t status);

struct davar_filter; /* davar/filter.h */

/** What a plan is made for. */
typedef struct {
    double rate_hz;        /**< of the samples */
    double unit_per_count; /**< deg/s */
    int32_t rail;          /**< a count of at least this size, of either sign, is clipped */
    /** samples between results; a window is four times as long and 32 samples. 0: 256 for 800 Hz
     * and more, 128 below */
    uint16_t block;
    /** between the noise and the samples, with its uncertainty; null: none. If there is one that you
     * do not know, do not use the floor: it reads far too low at the frequencies that are filtered */
    const struct davar_filter *filter;
} davar_floor_config_t;

/** What all axes of a gyro share. Fields are private. */
typedef struct {
    /** @privatesection */
    float weight[DAVAR_FLOOR_BINS]; /* 1 / power gain of difference and filter; 0: not usable */
    float passed[DAVAR_FLOOR_BINS]; /* power gain of the difference over that of both */
    float doubt[DAVAR_FLOOR_BINS];  /* relative standard error of the weight */
    float unit;                     /* deg/sqrt(h) of white noise of 1 count */
    int32_t rail;
    uint16_t segments; /* of a block */
    uint8_t usable;
} davar_floor_plan_t;

/** Makes a plan. A frequency is usable where the filter passes a tenth of the power (a hundredth if
 * it is known exactly) and its uncertainty leaves 0.3 of the density open.
 * @return DAVAR_FLOOR_OK, or what is wrong with the configuration; the plan is then not changed.
 *
 * Cost: with a filter, 99 davar_filter_power; once, or on the host. */
davar_floor_status_t davar_floor_plan(davar_floor_plan_t *plan, const davar_floor_config_t *config);

/** Why a result has no value. */
typedef enum {
    DAVAR_FLOOR_VALUE = 0,    /**< it has one */
    DAVAR_FLOOR_FILLING = 1,  /**< fewer than four blocks since the start or a gap */
    DAVAR_FLOOR_NARROW = 2,   /**< the filter leaves fewer than DAVAR_FLOOR_NEEDED frequencies */
    DAVAR_FLOOR_CLIPPED = 3,  /**< counts at the rail: use a larger range */
    DAVAR_FLOOR_COARSE = 4,   /**< rounding hides it: use a finer count */
    DAVAR_FLOOR_UNSTEADY = 5, /**< the noise changes within the window: use a shorter block */
    DAVAR_FLOOR_STILL = 6     /**< no count changes in 64 samples: the sensor is stuck */
} davar_floor_why_t;

/** Describes why in English, with what to do.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_floor_why_text(davar_floor_why_t why);

/** The floor of a window. Without a value, high is still an upper limit, or infinity (FILLING,
 * CLIPPED, STILL). */
typedef struct {
    davar_floor_why_t why; /**< DAVAR_FLOOR_VALUE: value is one */
    float value;           /**< deg/sqrt(h); NaN without one */
    float low;             /**< lower 95 % limit, deg/sqrt(h); NaN without a value */
    float high;            /**< upper 95 % limit, deg/sqrt(h) */
    float where;           /**< middle of the quiet frequencies, over the sample rate */
    float share;           /**< of the usable frequencies, how many are within twice the density */
    float unsteady; /**< relative standard deviation of the density in the window, if significant */
    uint16_t shocks;  /**< segments of 64 samples that were omitted as shocks */
    uint32_t clipped; /**< samples at the rail */
} davar_floor_result_t;

/** A window of one axis. Fields are private. */
typedef struct {
    /** @privatesection */
    float last;      /* sample */
    uint32_t fill;   /* place in the ring */
    uint32_t wait;   /* samples until a segment is complete */
    uint32_t beyond; /* samples at the rail since the last segment */
    uint32_t still;  /* segments until one without a difference leaves the window */
    float ring[64];  /* differences */
    float sum[DAVAR_FLOOR_BLOCKS][2][DAVAR_FLOOR_BINS]; /* of even and odd segments */
    float level[DAVAR_FLOOR_BLOCKS];  /* of the quiet frequencies: sums over segments, */
    float square[DAVAR_FLOOR_BLOCKS]; /* ... and of squares */
    float usual;                      /* that level of a segment, in the newest result */
    uint32_t clipped[DAVAR_FLOOR_BLOCKS];
    uint16_t taken[DAVAR_FLOOR_BLOCKS]; /* segments */
    uint16_t shocks[DAVAR_FLOOR_BLOCKS];
    uint8_t quiet[16]; /* frequencies */
    uint8_t quiet_count;
    uint8_t block;   /* the newest */
    uint8_t full;    /* blocks that are complete */
    uint8_t refused; /* segments in a row */
    uint8_t delay;   /* samples */
    bool is_odd;
    bool is_due;
} davar_floor_t;

/** Begins without samples. Cost: O(1). */
void davar_floor_start(davar_floor_t *floor);

/** For axes that get their samples together: lets the segments of this one end `samples` later, so
 * that their transforms take turns: 32 / axes apart. samples: at most 31 (asserted). Call it after
 * davar_floor_start. Cost: O(1). */
void davar_floor_delay(davar_floor_t *floor, uint8_t samples);

/** Adds a sample, in counts; of more than 24 bits, the lowest are rounded. For a sum of counts with
 * one at the rail, push INT32_MAX. Take the result before the next push, or it is lost.
 * @return True if a result is due.
 *
 * Cost: O(1); every 32nd sample a transform of 64 samples. */
bool davar_floor_push(davar_floor_t *floor, const davar_floor_plan_t *plan, int32_t count);

/** Computes the result that is due; before the first one, a result without a value. Cost: about that
 * of 80 samples. */
void davar_floor_take(davar_floor_t *floor, const davar_floor_plan_t *plan,
                      davar_floor_result_t *result);

/** Samples are missing before the next one: no segment spans them. Cost: O(1). */
void davar_floor_gap(davar_floor_t *floor);

/** @name Flights
 * Is this flight louder than earlier ones? The floor of one craft scatters by a quarter from flight to
 * flight, so an answer takes three earlier flights, and what counts is a factor of 1.5 or more. The
 * caller divides flight into bands in which the vibration is alike: five of throttle, for example.
 * Formulas (14.7). @{ */

#define DAVAR_FLOOR_BANDS 5U

/** Earlier flights of one axis, to store: 52 bytes without pointers. All zeros: none. */
typedef struct {
    float mean[DAVAR_FLOOR_BANDS];       /**< of the floors of flights, deg/sqrt(h) */
    float square[DAVAR_FLOOR_BANDS];     /**< sum of their squared distances from it */
    uint16_t flights[DAVAR_FLOOR_BANDS]; /**< flights with enough windows in the band */
} davar_floor_baseline_t;

/** One flight. All zeros: before the first window. */
typedef struct {
    float sum[DAVAR_FLOOR_BANDS];        /**< of floors, deg/sqrt(h) */
    uint32_t windows[DAVAR_FLOOR_BANDS]; /**< with a value */
} davar_floor_flight_t;

/** A flight against earlier ones. */
typedef struct {
    bool is_known; /**< false: fewer than three flights, or eight windows, in every band */
    float factor;  /**< this flight over the earlier ones; NaN if unknown */
    float low;     /**< 95 % limits of the factor without the scatter of flights: */
    float high;    /**< ... above 1 in low, it is significantly louder; 0 and infinity if unknown */
} davar_floor_change_t;

/** Adds a result to a flight, if it has a value. band: below DAVAR_FLOOR_BANDS (asserted).
 * Cost: O(1). */
void davar_floor_flight_add(davar_floor_flight_t *flight, uint32_t band,
                            const davar_floor_result_t *result);

/** Compares a flight with earlier ones, also while it lasts. Cost: about 500 operations. */
void davar_floor_compare(const davar_floor_baseline_t *baseline, const davar_floor_flight_t *flight,
                         davar_floor_change_t *change);

/** Adds a flight that has ended to the earlier ones. A flight that was louder for a reason, such as
 * a damaged propeller, does not belong there. Cost: O(1). */
void davar_floor_baseline_add(davar_floor_baseline_t *baseline, const davar_floor_flight_t *flight);

/** @} */

#ifdef __cplusplus
}
#endif

#endif
