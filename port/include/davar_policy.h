/** @file
 * davar - the window laws by number, for programs whose user selects one.
 *
 * A file that includes this header links all laws. */
#ifndef DAVAR_POLICY_H
#define DAVAR_POLICY_H

#include "davar/law.h"

/** The ids of the laws (davar/law.h). */
typedef enum {
    DAVAR_POLICY_FIXED = 0,    /**< no law: the window keeps its length */
    DAVAR_POLICY_KURTOSIS = 1, /**< davar_law_kurtosis */
    DAVAR_POLICY_OR = 2,       /**< davar_law_or */
    DAVAR_POLICY_AND = 3,      /**< davar_law_and */
    DAVAR_POLICY_GLR = 4       /**< davar_law_glr_q15 or davar_law_glr_q31 */
} davar_policy_t;

/** Returns the law for counts of 16 bits, or for wider ones and floats (is_wide). Null for the
 * fixed window. */
static inline const davar_law_t *davar_policy_law(davar_policy_t policy, bool is_wide)
{
    switch (policy) {
    case DAVAR_POLICY_KURTOSIS:
        return &davar_law_kurtosis;
    case DAVAR_POLICY_OR:
        return &davar_law_or;
    case DAVAR_POLICY_AND:
        return &davar_law_and;
    case DAVAR_POLICY_GLR:
        return is_wide ? &davar_law_glr_q31 : &davar_law_glr_q15;
    case DAVAR_POLICY_FIXED:
    default:
        return NULL;
    }
}

/** Sets the same law for the other number type in *config. */
static inline void davar_policy_retype(davar_config_t *config, bool is_wide)
{
    config->law = davar_policy_law((davar_policy_t)davar_law_id(config), is_wide);
}

#endif
