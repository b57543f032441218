/* davar-sim - learns the filter of a gyro from the spectrum of a recording at rest, DESIGN.md. */
#ifndef LEARN_H
#define LEARN_H

#include "davar/filter.h"
#include "learning/arma.h"
#include "learning/spectrum.h"

#define LEARN_SEGMENTS_LEAST 16U
#define LEARN_TEXT 512U /* characters of a filter as an option */

typedef enum {
    LEARN_NOTHING = 0, /* before learning */
    LEARN_FOUND,
    LEARN_NONE,    /* white up to half the sample rate */
    LEARN_WIDE,    /* white, but a wide low-pass is not excluded */
    LEARN_VAGUE,   /* the spectrum leaves the white noise before the filter open */
    LEARN_MISFIT,  /* no model explains the spectrum */
    LEARN_SHORT,   /* fewer than LEARN_SEGMENTS_LEAST segments at rest */
    LEARN_CONSTANT /* the signal does not change */
} learn_status_t;

typedef struct {
    learn_status_t status;
    davar_filter_t filter; /* of LEARN_FOUND; all zeros: none */
    unsigned averages;     /* in series, if the filter is moving averages; otherwise 0 */
    unsigned length;       /* samples of each */
    size_t segments;       /* at rest */
    size_t segment;        /* samples of each */
} learned_t;

/* The filter that explains a spectrum with the fewest numbers. */
typedef struct {
    davar_filter_t filter; /* all zeros: none */
    unsigned averages;     /* as in learned_t */
    unsigned length;
    arma_t model;     /* of what is before the averages */
    double criterion; /* Bayes', in units of log-likelihood */
} learn_choice_t;

void learn_choose(const arma_data_t *bins, learn_choice_t *choice);

/* Learns from the segments of one signal. rounding: variance of rounding to counts, in the unit of
 * the samples squared; 0: unknown. Sorts the segments. */
learned_t learn_filter(spectrum_t *spectrum, double rounding);

/* True if the filter may be declared. */
bool learn_knows(const learned_t *learned);

/* Writes what was learned, for example "a filter with -3 dB at 33.1 Hz (ARW known to 0.8 %)". */
void learn_describe(const learned_t *learned, double rate_hz, char text[LEARN_TEXT]);

/* Writes the same as a value of --bandwidth, "ba:..", "averageORDER:N" or "none"; "" if nothing is
 * known. */
void learn_option(const learned_t *learned, char text[LEARN_TEXT]);

#endif
