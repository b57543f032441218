/* davar - what each noise kind does to the overlapping Allan variance: its power of tau, its degrees of freedom, its
 * correlation between cluster sizes. Private to stage [5]. */
#ifndef DAVAR_NOISE_H
#define DAVAR_NOISE_H

#include "davar/types.h"
#include "number/scaled.h"

/* Terms of a model, and the one that is always there. */
#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE ((int)DAVAR_ANGLE_RANDOM_WALK)

/* Equivalent degrees of freedom of `differences` overlapping differences at cluster size m, never below 1 (5.1). */
double davar_noise_edf(davar_coefficient_kind_t noise, double m, double differences);

/* (white-noise edf at m) / (differences + m / 2), see (5.1). */
double davar_noise_white_weight(double m);

/* Sum over all lags of the squared cross-correlation of the kernels of two cluster sizes (short <= long), exact (5.3). */
double davar_noise_white_overlap(double m_short, double m_long);

/* Correlation of the Allan variances at two cluster sizes of one long window for a noise kind (5.8). */
double davar_noise_correlation(davar_coefficient_kind_t noise, double m_short, double m_long);

/* Of the fixed point 2.30. */
#define NOISE_BITS 30

/* The lower factor of davar_chi_square for s = edf^-1/2, 0 < s <= 1 (5.2); both as 2.30. */
uint32_t davar_chi_square_low(uint32_t s);

/* 95 % limits of a variance with edf degrees of freedom, edf >= 1, as factors (5.2). */
void davar_chi_square(scaled_t edf, scaled_t *low, scaled_t *high);

#endif
