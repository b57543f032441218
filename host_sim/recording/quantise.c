/* davar-sim - quantisation. */
#include "recording/quantise.h"

#include <float.h>
#include <math.h>

#define BITS_DEFAULT 24U
#define BITS_WIDE 32
#define FULL_SCALE_MIN 0x1p-66      /* the library rejects a full scale below 1e-20 */
#define COUNT_WIDE_MAX 2147483646.0 /* 2^31 - 1 is the rail, which counts as saturated */

static const char *admit_count(const options_t *options, unit_t unit, double value,
                               double *admitted)
{
    const uint32_t bits = (options->bits > 0U) ? options->bits : BITS_DEFAULT;
    const double limit = (double)(UINT64_C(1) << (bits - 1U));
    const double count =
        (unit == UNIT_COUNTS) ? value : round(value * unit_factor(unit) / options->setup.lsb);
    const bool inside = (count >= -limit) && (count <= limit - 1.0);
    const double whole = inside ? (double)(int32_t)count : round(count);
    if ((unit == UNIT_COUNTS) && (fabs(value - whole) > 0.0)) {
        return "not a whole count";
    }
    if (!inside) {
        return "value outside the count range (--bits, --lsb)";
    }
    *admitted = count;
    return NULL;
}

static const char *admit_rate(const options_t *options, unit_t unit, double value, double *admitted)
{
    const double rate = value * ((unit == UNIT_COUNTS) ? options->setup.lsb : unit_factor(unit));
    const double limit = (options->arith == ARITH_FLOAT) ? (double)FLT_MAX : DBL_MAX;
    if (fabs(rate) > limit) {
        return "value outside the range of the arithmetic (--arith)";
    }
    *admitted = rate;
    return NULL;
}

const char *quantise_admit(const options_t *options, unit_t unit, double value, double *admitted)
{
    const bool counted = (options->arith == ARITH_FIXED) && (options->setup.lsb > 0.0);
    return counted ? admit_count(options, unit, value, admitted)
                   : admit_rate(options, unit, value, admitted);
}

static double largest(const extent_t *extent)
{
    return fmax(fabs(extent->low), fabs(extent->high));
}

/* Exponent of the smallest power of two that is >= value; 0 for a recording of zeros. */
static int exponent_above(double value)
{
    if (!(value > 0.0)) {
        return 0;
    }
    int exponent = 0;
    const double fraction = frexp(value, &exponent);
    return (fraction > 0.5) ? exponent : exponent - 1;
}

/* 16 bits are enough if no count exceeds them. For a wider sensor no count may be at their rail
 * either, because only the narrow type would count saturation there. */
static bool fits_q15(uint32_t bits, const extent_t *extent)
{
    return (bits <= 16U) || ((extent->low > INT16_MIN) && (extent->high < INT16_MAX));
}

static quantisation_t plan_counts(const options_t *options, const extent_t *extent)
{
    const uint32_t bits = (options->bits > 0U) ? options->bits : BITS_DEFAULT;
    const bool narrow = fits_q15(bits, extent);
    return (quantisation_t){.number = narrow ? DAVAR_PORT_Q15 : DAVAR_PORT_Q31,
                            .unit_per_count = options->setup.lsb,
                            .full_scale = 1.0,
                            .sample_bits = (uint8_t)(narrow ? 16U : bits),
                            .step = 1.0};
}

static quantisation_t plan_finest(const extent_t *extent)
{
    double step = fmax(ldexp(1.0, exponent_above(largest(extent)) + 1 - BITS_WIDE), DBL_MIN);
    if (round(largest(extent) / step) > COUNT_WIDE_MAX) {
        step *= 2.0;
    }
    return (quantisation_t){.number = DAVAR_PORT_Q31,
                            .unit_per_count = step,
                            .full_scale = 1.0,
                            .sample_bits = BITS_WIDE,
                            .step = step};
}

static quantisation_t plan_float(const options_t *options, const extent_t *extent)
{
    double found = fmax(ldexp(1.0, exponent_above(largest(extent))), FULL_SCALE_MIN);
    if (!(largest(extent) < found)) { /* a sample at the full scale counts as saturated */
        found *= 2.0;
    }
    return (quantisation_t){.number = DAVAR_PORT_F32,
                            .unit_per_count = 1.0,
                            .full_scale = (options->full_scale > 0.0) ? options->full_scale : found,
                            .step = 1.0};
}

quantisation_t quantise_plan(const options_t *options, const extent_t *extent)
{
    if (options->arith == ARITH_FLOAT) {
        return plan_float(options, extent);
    }
    return (options->setup.lsb > 0.0) ? plan_counts(options, extent) : plan_finest(extent);
}
