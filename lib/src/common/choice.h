/* davar - what a configuration asks for, as far as the build has it (davar/options.h): each of these is false for the compiler
 * where it was left out, and what hangs on it is gone. */
#ifndef DAVAR_SRC_CHOICE_H
#define DAVAR_SRC_CHOICE_H

#include "davar/instance.h"

/* Windows about the epoch, of whatever policy. */
static inline bool looks_back(const davar_config_t *config)
{
    return DAVAR_CENTRED && (config->mode == DAVAR_MODE_CENTRED);
}

/* ... with mirrored ends: not those of policy glr, which end where the record does (10.15). */
static inline bool is_centred(const davar_config_t *config)
{
    return looks_back(config) && (!DAVAR_TRACKING || (config->policy != DAVAR_POLICY_GLR));
}

static inline bool is_adaptive(const davar_config_t *config)
{
    return DAVAR_ADAPTIVE && (config->policy != DAVAR_POLICY_FIXED);
}

/* The detector decides (10). */
static inline bool has_tracker(const davar_config_t *config)
{
    return DAVAR_TRACKING && (config->policy == DAVAR_POLICY_GLR);
}

/* ... or the moments do (4.1). */
static inline bool is_judged(const davar_config_t *config)
{
    return is_adaptive(config) && !has_tracker(config);
}

static inline bool has_moments(const davar_config_t *config)
{
    return DAVAR_ADAPTIVE && (config->segment != 0U);
}

/* ... about epochs that lie back (10.15): any edge may be needed once more, so they are on a grid at every stride. */
static inline bool tracks_about(const davar_config_t *config)
{
    return has_tracker(config) && looks_back(config);
}

#define HALF_BLOCKS_MAX 30U

/* Blocks of half such a window: 300 samples, as far as blocks are remembered. */
static inline uint32_t half_in_blocks(uint32_t block)
{
    const uint32_t half = 300U / block;
    return (half < HALF_BLOCKS_MAX) ? half : HALF_BLOCKS_MAX;
}

/* ... its samples, from the epoch to the end. */
static inline uint32_t half_in_samples(const davar_config_t *config)
{
    return half_in_blocks(config->block) * config->block;
}

/* Results come from records on a grid (2.7). */
static inline bool has_grid(const davar_config_t *config)
{
    const bool wanted = (config->stride > 1U) && (config->engine == DAVAR_ENGINE_GRID);
    return DAVAR_GRID && (wanted || tracks_about(config));
}

/* Samples pass the door of floats (2.3). */
static inline bool is_float(const davar_t *davar)
{
    return DAVAR_Q31 && davar->is_float;
}

/* The trailing edge still is in the mirrored start. */
static inline bool at_start(const davar_window_t *window)
{
    return DAVAR_CENTRED && window->at_start;
}

/* The leading edge runs into the mirrored end. */
static inline bool is_finished(const davar_window_t *window)
{
    return DAVAR_CENTRED && window->finished;
}

#endif
