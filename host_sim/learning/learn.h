/* davar-sim - learns the filter of a gyro from the spectrum of a recording at rest, DESIGN.md. */
#ifndef LEARN_H
#define LEARN_H

#include "davar/fit.h"
#include "learning/spectrum.h"

#define LEARN_SEGMENTS_LEAST 16U

typedef enum {
    LEARN_NOTHING = 0, /* before learning */
    LEARN_FOUND,
    LEARN_NONE,    /* white up to half the sample rate */
    LEARN_WIDE,    /* white, but a wide low-pass is not excluded */
    LEARN_VAGUE,   /* several filters explain the spectrum, with different white noise */
    LEARN_MISFIT,  /* no filter of the family explains the spectrum */
    LEARN_BEHIND,  /* noise after the filter, above its rounding, hides it */
    LEARN_SHORT,   /* fewer than LEARN_SEGMENTS_LEAST segments at rest */
    LEARN_CONSTANT /* the signal does not change */
} learn_status_t;

typedef struct {
    learn_status_t status;
    davar_filter_t filter; /* of LEARN_FOUND; all zeros: none */
    size_t segments;       /* at rest */
} learned_t;

/* Learns from the segments of one signal. rounding: variance of rounding to counts, in the unit of
 * the samples squared; 0: unknown. Sorts the segments. */
learned_t learn_filter(spectrum_t *spectrum, double rounding);

/* True if the filter may be declared. */
bool learn_knows(const learned_t *learned);

/* Writes what was learned, for example "two-pole low-pass at 33.1 Hz (+-0.4 Hz)". */
void learn_describe(const learned_t *learned, double rate_hz, char *text, size_t size);

/* Writes the same as a value of --bandwidth, for example "33.1:2:1.2"; "" if nothing is known. */
void learn_option(const learned_t *learned, double rate_hz, char *text, size_t size);

#endif
