/* davar-sim - from the values of a recording to the numbers an instance takes.
 * Two steps: admit, row by row while the recording is checked; then, with the whole recording known, a plan for all. */
#ifndef QUANTISE_H
#define QUANTISE_H

#include "davar_port.h"
#include "options/options.h"
#include "recording/unit.h"

/* Smallest and largest admitted number of the recording, all channels together. */
typedef struct {
    double low;
    double high;
} extent_t;

/* How a recording is taken in. */
typedef struct {
    davar_port_number_t number;
    double unit_per_count; /* fixed: size of a count; float: 1 */
    double full_scale;     /* float */
    uint8_t sample_bits;   /* fixed */
    double
        step; /* admitted numbers are divided by this before rounding; 1 when they are counts already */
} quantisation_t;

/* Turns one value of a column into what the spool keeps: a count (fixed with --lsb) or a rate. Returns null, or what is
 * wrong with the value: no whole count, beyond the count range, beyond float32. */
const char *quantise_admit(const options_t *options, unit_t unit, double value, double *admitted);

/* Chooses number type and scale for everything that was admitted. */
quantisation_t quantise_plan(const options_t *options, const extent_t *extent);

/* The count of an admitted number: divided by the step, rounded half away from zero. */
int32_t quantise_count(const quantisation_t *quantisation, double admitted);

#endif
