/* davar - float32 values for frames and packets. */
#include "wire/single.h"

#include "davar/wire.h"
#include "number/real.h"

uint32_t davar_single_bits(double value)
{
    return isnan(value) ? 0x7FC00000U : davar_bits_of_float((float)value);
}

double davar_single_signed(double value)
{
    const double size = fabs(value);
    const double shown = (size < (double)DAVAR_WIRE_LEAST) ? 0.0 : value;
    return (size <= (double)DAVAR_WIRE_MOST) ? shown : (double)NAN;
}

double davar_single_magnitude(double value)
{
    return davar_single_signed((value >= 0.0) ? value : (double)NAN);
}

double davar_single_limit(double value)
{
    return (value > (double)DAVAR_WIRE_MOST) ? (double)INFINITY : davar_single_magnitude(value);
}
