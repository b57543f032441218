/* davar - the second and fourth moments of a window: kurtosis and sliding contribution (3), and
 * whether they leave their bounds. Integers are compared, so that every target decides the same. */
#ifndef DAVAR_SRC_MOMENTS_H
#define DAVAR_SRC_MOMENTS_H

#include "davar/types.h"
#include "number/machine.h"

/* mantissa * 2^exponent, mantissa with its top bit set, or 0. */
typedef struct {
    uint64_t mantissa;
    int32_t exponent;
} davar_magnitude_t;

/* Second and fourth central moments of n samples, as the integers n^2 s^2 and n^4 m4 (3.3). */
typedef struct davar_central {
    davar_magnitude_t second;
    davar_magnitude_t fourth;
} davar_central_t;

/* How the flags of kurtosis and contribution are combined. */
typedef enum { RULE_KURTOSIS, RULE_OR, RULE_AND } davar_rule_t;

/* The flag f (3.4), from the whole window and its first part (without the short segment). Undefined
 * ratios (no variance) are not unstable. Relative error of the comparisons below 1e-17. */
bool davar_moments_unstable(const davar_config_t *config, davar_rule_t rule,
                            const davar_central_t *whole, const davar_central_t *first);

/* K (3.1); NaN without variance. */
double davar_kurtosis(const davar_central_t *whole);

/* S = |K - Km| / K (3.2); NaN without variance in either. */
double davar_contribution(const davar_central_t *whole, const davar_central_t *first);

void davar_magnitude_u64(davar_magnitude_t *result, uint64_t value);

/* (high 2^64 + low) 2^exponent, its top 64 bits. */
void davar_magnitude(davar_magnitude_t *result, uint64_t low, uint64_t high, int32_t exponent);

/* The kurtosis in 32 bits (3.5). K = 16 over / under. `over` is less than 1 below the true one,
 * and UINT32_MAX for K >= 16; `under` is at least 2^30 and less than 3 below the true one. No
 * variance: both are 0. Unknown: only `under` is 0. */
typedef struct davar_rough {
    uint32_t over;
    uint32_t under;
} davar_rough_t;

#endif
