/* davar - stage [3b]: is the window stationary? Kurtosis and sliding contribution against their bounds, decided in
 * integers so that every target decides alike. */
#ifndef DAVAR_SRC_STATIONARITY_H
#define DAVAR_SRC_STATIONARITY_H

#include "davar/types.h"
#include "number/machine.h"

/* mantissa * 2^exponent, mantissa with its top bit set, or 0. */
typedef struct {
    uint64_t mantissa;
    int32_t exponent;
} davar_magnitude_t;

/* Second and fourth central moments of n samples, as the integers n^2 s^2 and n^4 m4 (3.3). */
typedef struct {
    davar_magnitude_t second;
    davar_magnitude_t fourth;
} davar_central_t;

/* The flag f of the policy (3.4), from the whole window and its first part (without the short segment). Undefined
 * ratios (no variance) are not unstable. Fixed policy: f1 OR f2. Relative error of the comparisons below 1e-17. */
bool davar_stationarity_unstable(const davar_config_t *config, const davar_central_t *whole,
                                 const davar_central_t *first);

/* K (3.1); NaN without variance. */
double davar_stationarity_kurtosis(const davar_central_t *whole);

/* S = |K - Km| / K (3.2); NaN without variance in either. */
double davar_stationarity_contribution(const davar_central_t *whole, const davar_central_t *first);

void davar_magnitude_u64(davar_magnitude_t *result, uint64_t value);

/* (high 2^64 + low) 2^exponent, its top 64 bits. */
void davar_magnitude(davar_magnitude_t *result, uint64_t low, uint64_t high, int32_t exponent);

#endif
