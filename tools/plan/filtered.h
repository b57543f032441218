/* davar tools - white noise after a filter of the library, a sample at a time. */
#ifndef FILTERED_H
#define FILTERED_H

#include "davar/filter.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define AVERAGES 8U

/* One stream. Zeros: at rest. */
typedef struct {
    double before[DAVAR_FILTER_ZEROS + 1U]; /* noise, the newest first */
    double after[DAVAR_FILTER_POLES + 1U];
    double *average; /* rings of the moving averages, `length` samples each */
    double sum[AVERAGES];
    unsigned place;
} filtered_t;

/* Makes the gain at frequency 0 that of the samples, 1, and no filter b = 1. */
static inline void filtered_normalise(davar_filter_t *filter)
{
    double b = 0.0;
    double a = 0.0;
    filter->a[0] = 1.0;
    for (unsigned i = 0U; i <= DAVAR_FILTER_ZEROS; i++) {
        b += filter->b[i];
    }
    for (unsigned i = 0U; i <= DAVAR_FILTER_POLES; i++) {
        a += filter->a[i];
    }
    filter->b[0] += (fabs(b) > 0.0) ? 0.0 : 1.0;
    for (unsigned i = 0U; (fabs(b) > 0.0) && (i <= DAVAR_FILTER_ZEROS); i++) {
        filter->b[i] *= a / b;
    }
}

/* False: no memory. The stream keeps it until the program ends. */
static inline bool filtered_start(filtered_t *stream, const davar_filter_t *filter)
{
    memset(stream, 0, sizeof *stream);
    stream->average = calloc(((size_t)filter->averages * filter->length) + 1U, sizeof(double));
    return stream->average != NULL;
}

static inline double filtered_next(filtered_t *stream, const davar_filter_t *filter, double noise)
{
    double value = 0.0;
    memmove(&stream->before[1], stream->before, sizeof stream->before - sizeof stream->before[0]);
    memmove(&stream->after[1], stream->after, sizeof stream->after - sizeof stream->after[0]);
    stream->before[0] = noise;
    for (unsigned i = 0U; i <= DAVAR_FILTER_ZEROS; i++) {
        value += filter->b[i] * stream->before[i];
    }
    for (unsigned i = 1U; i <= DAVAR_FILTER_POLES; i++) {
        value -= filter->a[i] * stream->after[i];
    }
    stream->after[0] = value;
    for (unsigned k = 0U; k < filter->averages; k++) {
        double *const oldest = &stream->average[(k * filter->length) + stream->place];
        stream->sum[k] += value - *oldest;
        *oldest = value;
        value = stream->sum[k] / filter->length;
    }
    stream->place = (stream->place + 1U) % ((filter->averages > 0U) ? filter->length : 1U);
    return value;
}

#endif
