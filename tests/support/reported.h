/* davar tests - takes a result with its report of law glr, which belongs to the same epoch. */
#ifndef DAVAR_TESTS_REPORTED_H
#define DAVAR_TESTS_REPORTED_H

#include "davar/content.h"
#include "davar/davar.h"
#include "davar/glr.h"

#include <assert.h>

static inline bool take_reported(davar_t *davar, davar_result_t *result, davar_glr_report_t *report)
{
    const bool is_taken = davar_take(davar, result);
    if (is_taken) {
        davar_glr_report(davar, report);
        assert((davar_law_id(davar->config) != DAVAR_LAW_ID_GLR) ||
               (report->epoch == result->epoch));
    }
    return is_taken;
}

#endif
