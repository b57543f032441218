/** @file
 * davar - a filter as a user writes it in an option of a program.
 *
 * - HZ[:ORDER[:PERCENT]]: a low-pass of 1 or 2 poles (2) with its -3 dB frequency, known to so many
 *   percent (10)
 * - average[ORDER]:N: ORDER (1) moving averages of N samples, together at most 1024
 * - cic[ORDER]:N: the same, but every N-th sample is kept
 * - sum:N: the sums of N samples that davar_average makes
 * - FILTER+FILTER: a low-pass and then one of the others
 * - none: no filter */
#ifndef DAVAR_BANDWIDTH_H
#define DAVAR_BANDWIDTH_H

#include "davar/fit.h"
#include "davar_law_id.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** The forms above, for an error message. */
#define DAVAR_BANDWIDTH_FORMS                                                                      \
    "HZ[:ORDER[:PERCENT]] (order 1 or 2, at most 50 percent), average[ORDER]:N, cic[ORDER]:N or "  \
    "sum:N (N to 4096; ORDER times N of averages to 1024), HZ+average:N or none"

/** The range of a cutoff, for an error message. */
#define DAVAR_BANDWIDTH_RANGE                                                                      \
    "a cutoff from 0.002 times the sample rate to 2 times that before decimation"

/** A filter whose sample rate is not known yet. */
typedef struct {
    davar_filter_t filter; /**< cutoff is 0 */
    double hz;             /**< its cutoff, Hz; 0: no low-pass */
} davar_bandwidth_t;

/** Reads a whole number from 1 to most at *text and moves on. */
static inline bool davar_bandwidth_count(const char **text, uint32_t most, uint32_t *count)
{
    uint32_t value = 0U;
    const char *digit = *text;
    while ((*digit >= '0') && (*digit <= '9') && (value <= most)) {
        value = (10U * value) + (uint32_t)(*digit - '0');
        digit++;
    }
    const bool good = (digit != *text) && (value >= 1U) && (value <= most);
    *text = digit;
    *count = value;
    return good;
}

/** Reads the moving averages at *text and moves on. */
static inline bool davar_bandwidth_averages(const char **text, davar_filter_t *filter)
{
    uint32_t order = 1U;
    uint32_t length = 0U;
    const bool is_sum = strncmp(*text, "sum", 3U) == 0;
    const bool is_average = strncmp(*text, "average", 7U) == 0;
    *text += is_average ? 7U : 3U;
    bool good = is_sum || (**text == ':') || davar_bandwidth_count(text, 8U, &order);
    good = good && (**text == ':');
    *text += good ? 1U : 0U;
    good = good && davar_bandwidth_count(text, 4096U, &length);
    good = good && (!is_average || ((order * length) <= DAVAR_FILTER_SPAN_MOST));
    filter->averages = (uint8_t)order;
    filter->length = (uint16_t)length;
    filter->decimation = (uint16_t)(is_average ? 1U : length);
    filter->summed = (uint16_t)(is_sum ? length : 1U);
    return good;
}

/** Reads the low-pass at *text and moves on. */
static inline bool davar_bandwidth_low_pass(const char **text, davar_bandwidth_t *bandwidth)
{
    char *end = NULL;
    uint32_t order = 2U;
    double percent = 10.0;
    bandwidth->hz = strtod(*text, &end);
    bool good = (end != *text) && isfinite(bandwidth->hz) && (bandwidth->hz > 0.0);
    *text = end;
    if (good && (**text == ':')) {
        (*text)++;
        good = davar_bandwidth_count(text, 2U, &order);
        if (good && (**text == ':')) {
            const char *const begin = *text + 1;
            percent = strtod(begin, &end);
            good = (end != begin) && (percent >= 0.0) && (percent <= 50.0);
            *text = end;
        }
    }
    bandwidth->filter.poles = (uint8_t)order;
    bandwidth->filter.uncertainty = 0.01 * percent;
    return good;
}

/** Reads the complete text. @return False if it has another form, or a value out of range. */
static inline bool davar_bandwidth_read(const char *text, davar_bandwidth_t *bandwidth)
{
    *bandwidth = (davar_bandwidth_t){.hz = 0.0};
    if (strcmp(text, "none") == 0) {
        return true;
    }
    bool good = true;
    if ((*text >= '0') && (*text <= '9')) {
        good = davar_bandwidth_low_pass(&text, bandwidth);
        if (!good || (*text == '\0')) {
            return good;
        }
        good = (*text == '+');
        text++;
    }
    good = good &&
           ((strncmp(text, "cic", 3U) == 0) || (strncmp(text, "sum", 3U) == 0) ||
            (strncmp(text, "average", 7U) == 0)) &&
           davar_bandwidth_averages(&text, &bandwidth->filter);
    return good && (*text == '\0');
}

/** Writes the filter for a sample rate. @return False if its cutoff is out of range for it. */
static inline bool davar_bandwidth_at(const davar_bandwidth_t *bandwidth, double rate_hz,
                                      davar_filter_t *filter)
{
    *filter = bandwidth->filter;
    filter->cutoff = bandwidth->hz / rate_hz;
    const double decimation = (filter->decimation > 1U) ? (double)filter->decimation : 1.0;
    return (filter->poles == 0U) ||
           ((filter->cutoff >= 0.002) && (filter->cutoff <= (2.0 * decimation)));
}

/** Whitens for law glr. filter null: nothing is known about a filter. */
static inline void davar_bandwidth_whiten(davar_config_t *config, const davar_filter_t *filter)
{
    if ((filter != NULL) && (davar_law_id(config) == (uint8_t)DAVAR_LAW_ID_GLR)) {
        davar_whiten(config, filter);
    }
}

/** Prepares the plan of a fit for `count` cluster sizes m[]. filter null: nothing is known about a
 * filter. */
static inline void davar_bandwidth_plan(davar_plan_t *plan, const uint32_t *m, uint8_t count,
                                        const davar_filter_t *filter)
{
    if (filter == NULL) {
        davar_plan_init(plan, m, count);
    } else {
        davar_plan_init_filtered(plan, m, count, filter);
    }
}

#endif
