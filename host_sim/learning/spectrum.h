/* davar-sim - the spectrum of a signal at rest, from segments of a recording. */
#ifndef SPECTRUM_H
#define SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SPECTRUM_LONG 2048U     /* samples of a segment */
#define SPECTRUM_SHORT 512U     /* ... of a short recording */
#define SPECTRUM_MOST 1023U     /* ordinates of the longest segment */
#define SPECTRUM_SEGMENTS 1024U /* most segments: a memory of 4 MB */

typedef struct {
    size_t segment;   /* samples */
    size_t ordinates; /* of a segment; number j - 1 is at frequency j / segment */
    size_t count;     /* segments */
    float *power;     /* ordinates of each of them */
} spectrum_t;

/* Allocates the memory for a record of `samples` samples, and chooses the segment. False: out of
 * memory. */
bool spectrum_open(spectrum_t *spectrum, uint64_t samples);

/* Where the record is read: segments that overlap by half, of a long record as many as the memory
 * holds, spread evenly. */
size_t spectrum_places(const spectrum_t *spectrum, uint64_t samples);
uint64_t spectrum_place(const spectrum_t *spectrum, uint64_t samples, size_t i);

/* Adds a segment without a gap. More than SPECTRUM_SEGMENTS are ignored. */
void spectrum_add(spectrum_t *spectrum, const double *samples);

/* Writes the median spectrum of the segments at rest: variance per ordinate, so that white noise of
 * variance 1 has the power 1 at each. Returns the number of these segments. 0: no segments, or a
 * constant signal; power[] is then not valid. Sorts the segments in place. */
size_t spectrum_median(spectrum_t *spectrum, double power[SPECTRUM_MOST]);

/* Allowed if all zero, and after a failed open. */
void spectrum_close(spectrum_t *spectrum);

#endif
