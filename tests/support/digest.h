/* davar tests - a number for all values that a test has seen: FNV-1a, a word at a time. It is the
 * same on every machine; every NaN counts as the same value. It does without isnan, which a
 * compiler flag may bend. */
#ifndef DAVAR_TESTS_DIGEST_H
#define DAVAR_TESTS_DIGEST_H

#include "davar/glr.h"

#include <stdint.h>
#include <string.h>

static uint64_t digest;

static inline void digest_begin(void)
{
    digest = UINT64_C(14695981039346656037);
}

static inline void add(uint64_t value)
{
    digest = (digest ^ value) * UINT64_C(1099511628211);
}

static inline void add_double(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    add(((bits << 1U) > (UINT64_C(0x7FF) << 53U)) ? 1U : bits);
}

static inline void add_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    add(((bits << 1U) > (UINT32_C(0xFF) << 24U)) ? 1U : bits);
}

/* All fields that a caller reads; report: null without law glr. */
static inline void add_fields(const davar_result_t *result, const davar_glr_report_t *given)
{
    static const davar_glr_report_t none;
    const davar_glr_report_t *const report = (given != NULL) ? given : &none;
    add(result->epoch);
    add(result->window_samples + ((uint64_t)result->mirrored_samples << 32U));
    add(result->gaps_in_window + ((uint64_t)report->cut_age_samples << 32U));
    add(report->change.m);
    add_double(report->change.older);
    add_double(report->change.newer);
    add_double(report->change.gain);
    add(report->steady.samples);
    add_double(report->steady.level);
    add_double(report->steady.low);
    add_double(report->steady.high);
    add((result->unstable ? 1U : 0U) + (report->young ? 2U : 0U) + (report->alarm ? 4U : 0U) +
        (result->tau_count * 8U) + ((uint32_t)result->noise * 512U));
    add_double(result->unit_per_count);
    add_double(result->kurtosis);
    add_double(result->contribution);
    add_double(result->dispersion);
    for (uint32_t t = 0U; t < result->tau_count; t++) {
        const davar_adev_t *const tau = &result->tau[t];
        add(tau->m + ((uint64_t)tau->differences << 32U));
        add_double(tau->adev);
        add_double(tau->low);
        add_double(tau->high);
        add_double(tau->edf);
        add(tau->hops);
    }
    for (int kind = 0; kind < (int)DAVAR_COEFFICIENT_COUNT; kind++) {
        const davar_coefficient_t *const coefficient = &result->coefficient[kind];
        add(coefficient->present ? 1U : 0U);
        add_double(coefficient->value);
        add_double(coefficient->low);
        add_double(coefficient->high);
    }
}

#endif
