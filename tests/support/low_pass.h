/* davar tests - a gyro's low-pass at any rate, exact for white noise and for steps. */
#ifndef DAVAR_TESTS_LOW_PASS_H
#define DAVAR_TESTS_LOW_PASS_H

#include "shape.h"

#include <math.h>
#include <string.h>

#define LOW_PASS_PI 3.14159265358979324

/* A sampled low-pass of 1 or 2 poles as two states: the output, and its derivative over the cutoff.
 * No poles: it passes everything. */
typedef struct {
    double step[2][2];
    double noise[3]; /* Cholesky: of the output; of the derivative, shared and own */
    double state[2];
} low_pass_t;

static inline low_pass_t low_pass_of(const shape_t *filter, double oversampling)
{
    const double angle = 2.0 * LOW_PASS_PI * filter->cutoff / oversampling;
    low_pass_t low_pass = {.noise = {1.0, 0.0, 0.0}};
    if (filter->poles == 1U) {
        low_pass.step[0][0] = exp(-angle);
        low_pass.noise[0] = sqrt(1.0 - exp(-2.0 * angle));
    }
    if (filter->poles == 2U) {
        const double part = angle / sqrt(2.0);
        const double c = exp(-part) * cos(part);
        const double s = exp(-part) * sin(part);
        const double f[2][2] = {{c + s, sqrt(2.0) * s}, {-sqrt(2.0) * s, c - s}};
        const double q[3] = {1.0 - (f[0][0] * f[0][0]) - (f[0][1] * f[0][1]),
                             -(f[0][0] * f[1][0]) - (f[0][1] * f[1][1]),
                             1.0 - (f[1][0] * f[1][0]) - (f[1][1] * f[1][1])};
        memcpy(low_pass.step, f, sizeof f);
        low_pass.noise[0] = sqrt(q[0]);
        low_pass.noise[1] = q[1] / low_pass.noise[0];
        low_pass.noise[2] = sqrt(q[2] - (low_pass.noise[1] * low_pass.noise[1]));
    }
    return low_pass;
}

/* One sample later, with a constant input. */
static inline double low_pass_advance(low_pass_t *low_pass, double input, double first,
                                      double second)
{
    const double *const noise = low_pass->noise;
    const double x = low_pass->state[0] - input;
    const double v = low_pass->state[1];
    low_pass->state[0] =
        input + (low_pass->step[0][0] * x) + (low_pass->step[0][1] * v) + (noise[0] * first);
    low_pass->state[1] = (low_pass->step[1][0] * x) + (low_pass->step[1][1] * v) +
                         (noise[1] * first) + (noise[2] * second);
    return low_pass->state[0];
}

#endif
