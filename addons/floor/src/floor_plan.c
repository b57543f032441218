/* davar - floor: what the filter and the differences do to each frequency (14.3). */
#include "davar/filter.h"
#include "davar/floor.h"

#include "floor_transform.h"
#include "number/real.h"

#define FLOOR_PASSED_LEAST 0.1  /* of the power, by the filter, at a usable frequency; */
#define FLOOR_PASSED_EXACT 0.01 /* ... by a filter that is known exactly */
#define FLOOR_DOUBT_MOST 0.3    /* standard error of the density there, by the filter, relative */
#define FLOOR_BLOCK_LEAST 64U
#define FLOOR_BLOCK_MOST 4096U
#define FLOOR_SLOW_HZ 800.0 /* below, the usual block has half as many samples */

const char *davar_floor_status_text(davar_floor_status_t status)
{
    switch (status) {
    case DAVAR_FLOOR_OK:
        return "ok";
    case DAVAR_FLOOR_ERR_RATE:
        return "rate_hz is not positive and finite";
    case DAVAR_FLOOR_ERR_UNIT:
        return "unit_per_count is not positive and finite";
    case DAVAR_FLOOR_ERR_RAIL:
        return "rail is below 1";
    case DAVAR_FLOOR_ERR_BLOCK:
        return "block is not 0 and not a multiple of 64 from 64 to 4096";
    case DAVAR_FLOOR_ERR_FILTER:
        return "the filter is not valid";
    default:
        return "unknown status";
    }
}

const char *davar_floor_why_text(davar_floor_why_t why)
{
    switch (why) {
    case DAVAR_FLOOR_VALUE:
        return "it has a value";
    case DAVAR_FLOOR_FILLING:
        return "the window is filling: wait for four blocks";
    case DAVAR_FLOOR_NARROW:
        return "the filter leaves too few frequencies, or is known too little: give samples before "
               "it";
    case DAVAR_FLOOR_CLIPPED:
        return "counts at the end of the range: use a larger range";
    case DAVAR_FLOOR_COARSE:
        return "rounding hides the noise: use a finer count";
    case DAVAR_FLOOR_UNSTEADY:
        return "the noise changes within the window: use a shorter block";
    case DAVAR_FLOOR_STILL:
        return "no count changes in 64 samples: check the sensor";
    default:
        return "unknown reason";
    }
}

static bool is_usual(double value)
{
    return (value > 0.0) && (value <= 1e30);
}

static davar_floor_status_t check_floor(const davar_floor_config_t *config)
{
    if (!is_usual(config->rate_hz)) {
        return DAVAR_FLOOR_ERR_RATE;
    }
    if (!is_usual(config->unit_per_count)) {
        return DAVAR_FLOOR_ERR_UNIT;
    }
    if (config->rail < 1) {
        return DAVAR_FLOOR_ERR_RAIL;
    }
    if ((config->block > FLOOR_BLOCK_MOST) || ((config->block % FLOOR_BLOCK_LEAST) != 0U)) {
        return DAVAR_FLOOR_ERR_BLOCK;
    }
    return ((config->filter != NULL) && !davar_filter_is_valid(config->filter))
               ? DAVAR_FLOOR_ERR_FILTER
               : DAVAR_FLOOR_OK;
}

/* The Hann window mixes each frequency with its neighbours. */
static double smeared(const double at[DAVAR_FLOOR_BINS + 2U], uint32_t k)
{
    return (at[k - 1U] + 4.0 * at[k] + at[k + 1U]) / 6.0;
}

/* Power gain at k 64ths of the rate, if the filter is `factor` as wide as declared. */
static double passes_at(const davar_filter_t *filter, uint32_t k, double factor)
{
    const double frequency = (double)k / (factor * (double)FLOOR_SEGMENT);
    return (filter == NULL) ? 1.0 : davar_filter_power(filter, (frequency < 0.5) ? frequency : 0.5);
}

/* Relative standard error of the density of a frequency, by the filter (14.3): that of a digital
 * filter, or of one that is analogue, has as many poles and is sampled, if it is larger. */
static double doubt_at(const davar_filter_t *filter, uint32_t k)
{
    double poles = 0.0;
    if (filter == NULL) {
        return 0.0;
    }
    for (uint32_t i = 1U; i <= DAVAR_FILTER_POLES; i++) {
        poles = ((filter->a[i] > 0.0) || (filter->a[i] < 0.0)) ? (double)i : poles;
    }
    const double step = filter->uncertainty;
    const double wider = passes_at(filter, k, 1.0 + step);
    const double narrower = passes_at(filter, k, 1.0 - step);
    const double digital = (wider - narrower) / (wider + narrower);
    const double analogue = step * 2.0 * poles * (1.0 - passes_at(filter, k, 1.0));
    return ((digital > analogue) ? digital : analogue) + 2.0 * filter->level;
}

davar_floor_status_t davar_floor_plan(davar_floor_plan_t *plan, const davar_floor_config_t *config)
{
    const davar_floor_status_t status = check_floor(config);
    double difference[DAVAR_FLOOR_BINS + 2U];
    double through[DAVAR_FLOOR_BINS + 2U];
    double passes[DAVAR_FLOOR_BINS + 2U];
    if (status != DAVAR_FLOOR_OK) {
        return status;
    }
    for (uint32_t k = 0U; k <= DAVAR_FLOOR_BINS + 1U; k++) {
        passes[k] = passes_at(config->filter, k, 1.0);
        difference[k] = 2.0 - 2.0 * (double)floor_cosine(k);
        through[k] = difference[k] * passes[k];
    }
    plan->usable = 0U;
    for (uint32_t b = 0U; b < DAVAR_FLOOR_BINS; b++) {
        const double doubt = doubt_at(config->filter, b + 1U);
        const double least = (doubt > 0.0) ? FLOOR_PASSED_LEAST : FLOOR_PASSED_EXACT;
        const bool is_usable = (passes[b + 1U] >= least) && (doubt <= FLOOR_DOUBT_MOST);
        const double weight = is_usable ? (1.0 / smeared(through, b + 1U)) : 0.0;
        plan->weight[b] = (float)weight;
        plan->passed[b] = (float)(weight * smeared(difference, b + 1U));
        plan->doubt[b] = (float)doubt;
        plan->usable = (uint8_t)(plan->usable + (is_usable ? 1U : 0U));
    }
    plan->unit = (float)(60.0 * config->unit_per_count / davar_root(config->rate_hz));
    plan->rail = config->rail;
    const uint32_t usual = (config->rate_hz < FLOOR_SLOW_HZ) ? 128U : 256U;
    const uint32_t block = (config->block > 0U) ? (uint32_t)config->block : usual;
    plan->segments = (uint16_t)(block / FLOOR_HOP);
    return DAVAR_FLOOR_OK;
}
