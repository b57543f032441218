/* davar-sim - the spectrum of a signal at rest, from segments of a recording. */
#ifndef SPECTRUM_H
#define SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SPECTRUM_SEGMENT 512U   /* samples of a segment */
#define SPECTRUM_ORDINATES 255U /* ordinate j - 1 is at frequency j / SPECTRUM_SEGMENT */
#define SPECTRUM_SEGMENTS 1024U /* most segments: a memory of 1 MB */

typedef struct {
    size_t count; /* segments */
    float *power; /* SPECTRUM_ORDINATES for each of them */
} spectrum_t;

/* Where a record of `samples` samples is read: segments that overlap by half, of a long record as
 * many as the memory holds, spread evenly. */
size_t spectrum_places(uint64_t samples);
uint64_t spectrum_place(uint64_t samples, size_t i);

/* False: out of memory. */
bool spectrum_open(spectrum_t *spectrum);

/* Adds a segment of SPECTRUM_SEGMENT samples without a gap. More than SPECTRUM_SEGMENTS are
 * ignored. */
void spectrum_add(spectrum_t *spectrum, const double *samples);

/* Writes the median spectrum of the segments at rest: variance per ordinate, so that white noise of
 * variance 1 has the power 1 at each. Returns the number of these segments. 0: no segments, or a
 * constant signal; power[] is then not valid. Sorts the segments in place. */
size_t spectrum_median(spectrum_t *spectrum, double power[SPECTRUM_ORDINATES]);

/* Allowed if all zero, and after a failed open. */
void spectrum_close(spectrum_t *spectrum);

#endif
