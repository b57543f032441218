/* davar tests - a result, with what law glr reports. */
#ifndef DAVAR_TESTS_REPORTED_H
#define DAVAR_TESTS_REPORTED_H

#include "davar/davar.h"
#include "davar/glr.h"

static inline bool take_reported(davar_t *davar, davar_result_t *result, davar_glr_report_t *report)
{
    const bool is_taken = davar_take(davar, result);
    if (is_taken) {
        davar_glr_report(davar, report);
    }
    return is_taken;
}

#endif
