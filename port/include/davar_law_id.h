/** @file
 * davar - window laws and engines by number, for programs whose user selects them.
 *
 * A file that includes this header links all of them. */
#ifndef DAVAR_LAW_ID_H
#define DAVAR_LAW_ID_H

#include "davar/content.h"
#include "davar/glr.h"

/** Returns the law for counts of 16 bits, or for wider ones and floats (is_wide). Null for the
 * fixed window. */
static inline const davar_law_t *davar_law_of_id(davar_law_id_t id, bool is_wide)
{
    switch (id) {
    case DAVAR_LAW_ID_KURTOSIS:
        return &davar_law_kurtosis;
    case DAVAR_LAW_ID_OR:
        return &davar_law_or;
    case DAVAR_LAW_ID_AND:
        return &davar_law_and;
    case DAVAR_LAW_ID_GLR:
        return is_wide ? &davar_law_glr_q31 : &davar_law_glr_q15;
    case DAVAR_LAW_ID_FIXED:
    default:
        return NULL;
    }
}

/** Returns the grid, or null if it is not wanted. */
static inline const davar_engine_t *davar_grid_of(bool is_wanted, bool is_wide)
{
    const davar_engine_t *const grid = is_wide ? &davar_engine_grid_q31 : &davar_engine_grid_q15;
    return is_wanted ? grid : NULL;
}

/** Sets the same law and engine for the other number type in *config. */
static inline void davar_retype(davar_config_t *config, bool is_wide)
{
    config->law = davar_law_of_id(davar_law_id(config), is_wide);
    config->engine = davar_grid_of(config->engine != NULL, is_wide);
}

#endif
