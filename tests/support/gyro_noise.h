/* davar tests - rate records with a known Allan variance: any mix of the five noise terms, in
 * sample units (tau0 = 1 s). */
#ifndef DAVAR_TESTS_GYRO_NOISE_H
#define DAVAR_TESTS_GYRO_NOISE_H

#include "random.h"

#include <stddef.h>

/* avar(m) = 3 Q^2 / m^2 + N^2 / m + (2 ln2 / pi) B^2 + K^2 m / 3 + R^2 m^2 / 2. Exact except for
 * flicker, a sum of Gauss-Markov processes whose plateau is flat within 2 % from m = 2 onward.
 * gyro_noise_avar() is the true Allan variance of gyro_noise_fill(), including that detail. */
typedef struct {
    double quantization;
    double white;
    double flicker;
    double walk;
    double ramp;
    double low_pass; /* > 0: white noise through y += (x - y) * low_pass, a filtered sensor */
} gyro_noise_t;

void gyro_noise_fill(const gyro_noise_t *noise, random_t *random, double *rate, size_t count);
double gyro_noise_avar(const gyro_noise_t *noise, unsigned m);

#endif
