/* davar-sim - converts the values of a recording to the numbers of an instance, in two steps. Step
 * 1 admits each value while the recording is checked. Step 2 plans the scale for the complete
 * recording. */
#ifndef QUANTISE_H
#define QUANTISE_H

#include "davar_port.h"
#include "options/options.h"
#include "recording/unit.h"

/* Smallest and largest admitted number of the recording, over all channels. */
typedef struct {
    double low;
    double high;
} extent_t;

/* Number type and scale of a recording. */
typedef struct {
    davar_port_number_t number;
    double unit_per_count; /* fixed: size of a count; float: 1 */
    double full_scale;     /* float */
    uint8_t sample_bits;   /* fixed */
    /* admitted numbers are divided by this before rounding; 1 if they are counts already */
    double step;
} quantisation_t;

/* Converts one value of a column to the number in the spool: a count (fixed with --lsb) or a rate.
 * Returns null, or the error: not a whole count, outside the count range, outside float32. */
const char *quantise_admit(const options_t *options, unit_t unit, double value, double *admitted);

/* Chooses number type and scale for all admitted numbers. */
quantisation_t quantise_plan(const options_t *options, const extent_t *extent);

/* The count of an admitted number: divided by the step, rounded half away from zero. */
static inline int32_t quantise_count(const quantisation_t *quantisation, double admitted)
{
    const double steps = admitted / quantisation->step;
    const int32_t whole = (int32_t)steps;
    const double rest = steps - whole; /* exact */
    return whole + ((rest >= 0.5) ? 1 : 0) - ((rest <= -0.5) ? 1 : 0);
}

#endif
