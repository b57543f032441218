/* davar tests - a result with its fit, with a plan for it alone. */
#ifndef DAVAR_TESTS_FITTED_H
#define DAVAR_TESTS_FITTED_H

#include "davar/davar.h"
#include "davar/fit.h"

static inline bool take_fitted(davar_t *davar, davar_result_t *result)
{
    davar_plan_t plan;
    const bool waits = davar_take(davar, result);
    if (waits) {
        davar_plan_init_white(&plan, davar->config->taus, davar->config->tau_count);
        davar_fit(&plan, davar->config->rate_hz, result);
    }
    return waits;
}

#endif
