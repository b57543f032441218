/* davar - floor: periodograms of differences in two halves of a window. Each half chooses the
 * quietest quarter of the frequencies and the other one measures it (14.2) to (14.5). */
#include "davar/floor.h"

#include "floor_transform.h"
#include "number/scaled.h"

#include <string.h>

#define FLOOR_BINS DAVAR_FLOOR_BINS
#define FLOOR_BLOCKS DAVAR_FLOOR_BLOCKS

#define FLOOR_SHOCK 16.0F        /* times the usual level of a segment, */
#define FLOOR_SHOCKS_IN_A_ROW 3  /* ... up to so many; then it is a change */
#define FLOOR_NEXT (4.0F / 9.0F) /* correlation of neighbouring frequencies, by the window, */
#define FLOOR_AFTER_NEXT (1.0F / 36.0F) /* ... and of segments that overlap by half, or two apart */
#define FLOOR_BROUGHT_BACK 0.07F /* of the bias of choosing, by segments that overlap (14.4) */
#define FLOOR_IN_COMMON 0.43F    /* correlation of the two measures, if they choose apart (14.5) */
#define FLOOR_WRONG_CHOICE 0.0009F /* variance by wrong choices, relative */
#define FLOOR_CHANGING_MOST 4.0F   /* variance of the density in the window, relative */
#define FLOOR_DEGREES_LEAST 8.0F
#define FLOOR_COARSE 1.5F  /* times the variance of rounding, below which that hides the noise */
#define FLOOR_DITHER 0.29F /* half the mean square step, below which rounding is not white */
#define FLOOR_NORMAL_95 1.96F
#define FLOOR_CUBE_LEAST 1e-4F
#define FLOOR_QUARTER_MOST 8U

/* --- samples in ------------------------------------------------------------------------------- */

/* The difference of the first sample is none, and is written over as those of a delay are: a segment
 * always ends at the end of the ring, or in its middle. */
void davar_floor_gap(davar_floor_t *floor)
{
    floor->fill = FLOOR_SEGMENT - 1U - floor->delay;
    floor->wait = FLOOR_SEGMENT + 1U + floor->delay;
}

void davar_floor_delay(davar_floor_t *floor, uint8_t samples)
{
    DAVAR_ASSERT(samples <= 31U);
    floor->delay = samples;
    davar_floor_gap(floor);
}

void davar_floor_start(davar_floor_t *floor)
{
    memset(floor, 0, sizeof *floor);
    davar_floor_gap(floor);
}

/* The window moves on by a block. Its sums are written, not added to, by its first segments. */
static void begin_block(davar_floor_t *floor)
{
    const uint32_t k = (floor->block + 1U) % FLOOR_BLOCKS;
    floor->is_due = false;
    floor->block = (uint8_t)k;
    floor->level[k] = 0.0F;
    floor->square[k] = 0.0F;
    floor->taken[k] = 0U;
    floor->shocks[k] = 0U;
    floor->clipped[k] = 0U;
}

static float quiet_level(const davar_floor_t *floor, const float power[FLOOR_BINS])
{
    float level = 0.0F;
    for (uint32_t i = 0U; i < floor->quiet_count; i++) {
        level += power[floor->quiet[i]];
    }
    return level;
}

/* Adds a periodogram to one of the halves of its block. */
static void add_segment(davar_floor_t *floor)
{
    const uint32_t k = floor->block;
    float power[FLOOR_BINS];
    davar_floor_transform(floor->ring, floor->fill, power);
    const float level = quiet_level(floor, power);
    if ((floor->quiet_count > 0U) && (level > FLOOR_SHOCK * floor->usual) &&
        (floor->refused < FLOOR_SHOCKS_IN_A_ROW)) {
        floor->refused++;
        floor->shocks[k]++;
        return;
    }
    float *const sum = floor->sum[k][floor->is_odd ? 1 : 0];
    const float keep = (floor->taken[k] < 2U) ? 0.0F : 1.0F;
    for (uint32_t b = 0U; b < FLOOR_BINS; b++) {
        sum[b] = keep * sum[b] + power[b];
    }
    floor->refused = 0U;
    floor->level[k] += level;
    floor->square[k] += level * level;
    floor->taken[k]++;
    floor->is_odd = !floor->is_odd;
}

/* The ring is full of one run. One without any difference is that of a stuck sensor, until it has
 * left the window; noise ends the search at once. Apart, so that other samples save no registers. */
DAVAR_APART static bool end_segment(davar_floor_t *floor, const davar_floor_plan_t *plan)
{
    uint32_t same = 0U;
    if (floor->is_due) {
        begin_block(floor);
    }
    while ((same < FLOOR_SEGMENT) && !((floor->ring[same] < 0.0F) || (floor->ring[same] > 0.0F))) {
        same++;
    }
    floor->still -= (floor->still > 0U) ? 1U : 0U;
    if (same == FLOOR_SEGMENT) {
        floor->still = FLOOR_BLOCKS * plan->segments;
    }
    floor->clipped[floor->block] += floor->beyond;
    floor->beyond = 0U;
    floor->wait = FLOOR_HOP;
    add_segment(floor);
    floor->is_due = (floor->taken[floor->block] + floor->shocks[floor->block]) >= plan->segments;
    floor->full =
        (uint8_t)(floor->full + ((floor->is_due && (floor->full < FLOOR_BLOCKS)) ? 1U : 0U));
    return floor->is_due;
}

bool davar_floor_push(davar_floor_t *floor, const davar_floor_plan_t *plan, int32_t count)
{
    const float value = (float)count;
    const uint32_t fill = floor->fill;
    floor->ring[fill] = value - floor->last;
    floor->last = value;
    floor->fill = (fill + 1U) % FLOOR_SEGMENT;
    floor->wait--;
    if ((count >= plan->rail) || (count <= -plan->rail)) {
        floor->beyond++;
    }
    return (floor->wait == 0U) && end_segment(floor, plan);
}

/* --- a result out ----------------------------------------------------------------------------- */

/* The window: densities of both halves without the filter, in counts squared. */
typedef struct {
    float half[2][FLOOR_BINS];
    float mean[FLOOR_BINS];
    float segments;
    float level;
    float square;
} window_t;

static void read_blocks(const davar_floor_t *floor, const davar_floor_plan_t *plan,
                        window_t *window, davar_floor_result_t *result)
{
    uint32_t clipped = 0U;
    uint32_t shocks = 0U;
    float is_counted[FLOOR_BLOCKS]; /* a block of shocks is not */
    for (uint32_t k = 0U; k < FLOOR_BLOCKS; k++) {
        is_counted[k] = (floor->taken[k] < 2U) ? 0.0F : 1.0F;
        window->segments += is_counted[k] * (float)floor->taken[k];
        window->level += is_counted[k] * floor->level[k];
        window->square += is_counted[k] * floor->square[k];
        shocks += floor->shocks[k];
        clipped += floor->clipped[k];
    }
    result->shocks = (uint16_t)shocks;
    result->clipped = clipped;
    /* Each half has half of the segments; the transform is four times the power. */
    const float scale = 2.0F / (4.0F * FLOOR_ENERGY * window->segments);
    for (uint32_t b = 0U; b < FLOOR_BINS; b++) {
        const float weight = scale * plan->weight[b];
        for (uint32_t h = 0U; h < 2U; h++) {
            float sum = 0.0F;
            for (uint32_t k = 0U; k < FLOOR_BLOCKS; k++) {
                sum += is_counted[k] * floor->sum[k][h][b];
            }
            window->half[h][b] = weight * sum;
        }
        window->mean[b] = 0.5F * (window->half[0][b] + window->half[1][b]);
    }
}

/* The frequencies that a half of the window chooses. */
typedef struct {
    uint8_t place[FLOOR_QUARTER_MOST];
    uint32_t mask;
} choice_t;

/* A frequency smoothed with its usable neighbours. */
static float smoothed(const davar_floor_plan_t *plan, const float y[FLOOR_BINS], uint32_t b)
{
    const uint32_t below = ((b > 0U) && (plan->weight[b - 1U] > 0.0F)) ? (b - 1U) : b;
    const uint32_t above = ((b + 1U < FLOOR_BINS) && (plan->weight[b + 1U] > 0.0F)) ? (b + 1U) : b;
    return 0.25F * (y[below] + y[above]) + 0.5F * y[b];
}

/* The n quietest of the usable frequencies, by insertion. */
static void choose_quarter(const davar_floor_plan_t *plan, const float y[FLOOR_BINS], uint32_t n,
                           choice_t *choice)
{
    float least[FLOOR_QUARTER_MOST] = {0.0F};
    uint32_t count = 0U;
    choice->mask = 0U;
    for (uint32_t b = 0U; b < FLOOR_BINS; b++) {
        const float here = smoothed(plan, y, b);
        if (!(plan->weight[b] > 0.0F) || ((count == n) && !(here < least[n - 1U]))) {
            continue;
        }
        uint32_t at = (count < n) ? count : (n - 1U);
        count = at + 1U;
        for (; (at > 0U) && (here < least[at - 1U]); at--) {
            least[at] = least[at - 1U];
            choice->place[at] = choice->place[at - 1U];
        }
        least[at] = here;
        choice->place[at] = (uint8_t)b;
    }
    for (uint32_t i = 0U; i < count; i++) {
        choice->mask |= UINT32_C(1) << choice->place[i];
    }
}

/* Relative variance of the mean over chosen frequencies of one periodogram (14.5). */
static float choice_variance(const window_t *window, const choice_t *choice, uint32_t n)
{
    float sum = 0.0F;
    float squares = 0.0F;
    for (uint32_t i = 0U; i < n; i++) {
        sum += window->mean[choice->place[i]];
    }
    const float share = (sum > 0.0F) ? (1.0F / sum) : 0.0F; /* squares of counts would overflow */
    for (uint32_t i = 0U; i < n; i++) {
        const uint32_t b = choice->place[i];
        const uint32_t above = choice->mask >> b;
        const float next = ((above & 2U) != 0U) ? window->mean[b + 1U] : 0.0F;
        const float after = ((above & 4U) != 0U) ? window->mean[b + 2U] : 0.0F;
        const float y = share * window->mean[b];
        squares += y * (y + share * (2.0F * FLOOR_NEXT * next + 2.0F * FLOOR_AFTER_NEXT * after));
    }
    return squares;
}

/* What the two choices give together. */
typedef struct {
    float density;  /* with rounding */
    float rounding; /* part of it */
    float variance; /* relative, of one periodogram */
    float doubt;    /* relative standard deviation by the filter */
    float common;   /* share of the choices that agree */
    float step;     /* half the mean square difference of two samples */
    uint32_t quiet; /* chosen by either */
    uint32_t n;
} measure_t;

static measure_t measure_quarter(const davar_floor_plan_t *plan, const window_t *window,
                                 davar_floor_result_t *result)
{
    measure_t found = {.n = (plan->usable + 2U) / 4U};
    choice_t choice[2];
    const float weight = 0.5F / (float)found.n;
    float own = 0.0F;
    float crossed = 0.0F;
    uint32_t places = 0U;
    for (uint32_t h = 0U; h < 2U; h++) {
        choose_quarter(plan, window->half[h], found.n, &choice[h]);
        for (uint32_t i = 0U; i < found.n; i++) {
            const uint32_t b = choice[h].place[i];
            own += window->half[h][b];
            crossed += window->half[1U - h][b];
            found.rounding += plan->passed[b];
            found.doubt += plan->doubt[b];
            places += b + 1U;
        }
        found.variance += 0.5F * choice_variance(window, &choice[h], found.n);
    }
    uint32_t both = choice[0].mask & choice[1].mask;
    for (; both != 0U; both &= both - 1U) {
        found.common += 2.0F * weight;
    }
    found.density = weight * (crossed + FLOOR_BROUGHT_BACK * (crossed - own));
    found.rounding *= weight / 12.0F;
    found.doubt *= weight;
    found.quiet = choice[0].mask | choice[1].mask;
    result->where = weight * (float)places / (float)FLOOR_SEGMENT;
    return found;
}

/* What all usable frequencies say: how many are near the density, and half the mean square step of
 * a count. Keeps the quiet ones, and their usual level, for the next segments. */
static void look_around(davar_floor_t *floor, const davar_floor_plan_t *plan,
                        const window_t *window, measure_t *found, davar_floor_result_t *result)
{
    const float usable = (float)plan->usable;
    const float most = 2.0F * found->density;
    uint32_t near = 0U;
    float all = 0.0F;
    float quiet = 0.0F;
    floor->quiet_count = 0U;
    for (uint32_t b = 0U; b < FLOOR_BINS; b++) {
        if (plan->weight[b] > 0.0F) {
            const float power = window->mean[b] / plan->weight[b];
            near += (window->mean[b] < most) ? 1U : 0U;
            all += power;
            if (((found->quiet >> b) & 1U) != 0U) {
                quiet += power;
                floor->quiet[floor->quiet_count] = (uint8_t)b;
                floor->quiet_count++;
            }
        }
    }
    floor->usual = quiet * 4.0F * FLOOR_ENERGY;
    found->step = 0.5F * all / usable;
    result->share = (float)near / usable;
}

/* Relative variance of the density within the window, beyond chance. */
static float level_variance(const window_t *window, float variance)
{
    const float mean = window->level / window->segments;
    if (!(mean > 0.0F)) {
        return 0.0F;
    }
    const float scatter = (window->square / window->segments - mean * mean) / (mean * mean);
    return (scatter > 2.5F * variance) ? (scatter - 1.5F * variance) : 0.0F;
}

/* Degrees of freedom of the density as a chi-square (14.5). */
static float floor_degrees(const measure_t *found, float segments, float change)
{
    const float agreed = (found->common - 0.25F) / 0.75F;
    const float apart = (agreed < 1.0F) ? (1.0F - ((agreed > 0.0F) ? agreed : 0.0F)) : 0.0F;
    const float most = (change < FLOOR_CHANGING_MOST) ? change : FLOOR_CHANGING_MOST;
    const float back = (1.0F + FLOOR_BROUGHT_BACK) * (1.0F + FLOOR_BROUGHT_BACK);
    const float variance = found->variance * ((1.0F + 2.0F * FLOOR_AFTER_NEXT) / segments) *
                           (1.0F + FLOOR_IN_COMMON * apart) * back * (1.0F + most);
    return 2.0F / (variance + FLOOR_WRONG_CHOICE + found->doubt * found->doubt);
}

/* Density over that of one limit, after Wilson and Hilferty. */
static float floor_limit(float degrees, float sigmas)
{
    const float part = 2.0F / (9.0F * degrees);
    const float third = 1.0F - part + sigmas * scaled_root_of_float(part);
    const float cube = third * third * third;
    return 1.0F / ((cube > FLOOR_CUBE_LEAST) ? cube : FLOOR_CUBE_LEAST);
}

static davar_floor_why_t floor_why(const davar_floor_t *floor, const davar_floor_plan_t *plan,
                                   const measure_t *found, const davar_floor_result_t *result,
                                   float degrees)
{
    if (floor->full < FLOOR_BLOCKS) {
        return DAVAR_FLOOR_FILLING;
    }
    if (result->clipped > 0U) {
        return DAVAR_FLOOR_CLIPPED;
    }
    if (floor->still > 0U) {
        return DAVAR_FLOOR_STILL;
    }
    if (plan->usable < DAVAR_FLOOR_NEEDED) {
        return DAVAR_FLOOR_NARROW;
    }
    if ((found->density < FLOOR_COARSE * found->rounding) || (found->step < FLOOR_DITHER)) {
        return DAVAR_FLOOR_COARSE;
    }
    return (degrees >= FLOOR_DEGREES_LEAST) ? DAVAR_FLOOR_VALUE : DAVAR_FLOOR_UNSTEADY;
}

static void write_floor(const davar_floor_plan_t *plan, const measure_t *found, float degrees,
                        davar_floor_result_t *result)
{
    const bool has_value = (result->why == DAVAR_FLOOR_VALUE);
    const bool has_high = (result->why != DAVAR_FLOOR_FILLING) &&
                          (result->why != DAVAR_FLOOR_CLIPPED) &&
                          (result->why != DAVAR_FLOOR_STILL);
    const float rounding = has_value ? found->rounding : 0.0F;
    const float low = found->density * floor_limit(degrees, FLOOR_NORMAL_95) - rounding;
    const float high = found->density * floor_limit(degrees, -FLOOR_NORMAL_95) - rounding;
    if (has_value) {
        result->value = plan->unit * scaled_root_of_float(found->density - rounding);
        result->low = plan->unit * scaled_root_of_float(low);
    }
    if (has_high) {
        result->high = plan->unit * scaled_root_of_float(high);
    }
}

void davar_floor_take(davar_floor_t *floor, const davar_floor_plan_t *plan,
                      davar_floor_result_t *result)
{
    window_t window = {.segments = 0.0F};
    *result = (davar_floor_result_t){.value = NAN, .low = NAN, .high = HUGE_VALF};
    read_blocks(floor, plan, &window, result);
    if (!(window.segments > 0.0F) || (plan->usable < DAVAR_FLOOR_LIMITED)) {
        result->why =
            (plan->usable < DAVAR_FLOOR_LIMITED) ? DAVAR_FLOOR_NARROW : DAVAR_FLOOR_FILLING;
        floor->is_due = false;
        return;
    }
    measure_t found = measure_quarter(plan, &window, result);
    const float change = level_variance(&window, found.variance);
    const float degrees = floor_degrees(&found, window.segments, change);
    look_around(floor, plan, &window, &found, result);
    result->unsteady = scaled_root_of_float(change);
    result->why = floor_why(floor, plan, &found, result, degrees);
    write_floor(plan, &found, degrees, result);
    if (floor->is_due) {
        begin_block(floor);
    }
}
