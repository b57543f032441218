/* davar - float32 values for frames and packets: their bits, and what may be sent. */
#ifndef DAVAR_SRC_SINGLE_H
#define DAVAR_SRC_SINGLE_H

#include <stdint.h>

/* The bits of (float)value. NaN has the same bits on every machine. */
uint32_t davar_single_bits(double value);

/* The value, 0 below DAVAR_WIRE_LEAST, or NaN above DAVAR_WIRE_MOST. NaN stays NaN. */
double davar_single_signed(double value);

/* The same; a negative value becomes NaN. */
double davar_single_magnitude(double value);

/* The same for an upper limit: above DAVAR_WIRE_MOST it is infinity, which is no limit. */
double davar_single_limit(double value);

#endif
