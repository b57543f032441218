/* davar tests - flights with redundant gyros: samples of two to four gyros that share motion and
 * vibration and have noise of their own. */
#ifndef DAVAR_TESTS_FLIGHT_H
#define DAVAR_TESTS_FLIGHT_H

#include "davar/select.h"
#include "random.h"

#include <stdbool.h>
#include <string.h>

#define FLIGHT_SIGMA 0.05 /* deg/s: of a sample of a gyro whose relative noise is 1 */

typedef enum {
    NOISE_GAUSS,
    NOISE_LAPLACE,
    NOISE_STUDENT_5,   /* degrees of freedom */
    NOISE_MARKOV,      /* AR(1) of 0.7 a sample */
    NOISE_MARKOV_STEP, /* the steps from sample to sample are AR(1) of 0.7 */
    NOISE_HELD         /* three equal samples each: a third of the degrees of freedom */
} flight_noise_t;

typedef struct {
    random_t random;
    bool has_gauss;
    double gauss;
    /* of the gyros */
    uint32_t gyros;
    uint32_t axes;
    flight_noise_t kind;
    double own[DAVAR_SELECT_GYROS]; /* relative noise, standard deviation */
    double scale[DAVAR_SELECT_GYROS];
    double delay_s[DAVAR_SELECT_GYROS];
    double bias[DAVAR_SELECT_GYROS][DAVAR_SELECT_AXES];
    double heat[DAVAR_SELECT_GYROS]; /* bias after a long warm-up, deg/s */
    double state[DAVAR_SELECT_GYROS][DAVAR_SELECT_AXES];
    double held[DAVAR_SELECT_GYROS][DAVAR_SELECT_AXES];
    /* of the vehicle */
    double rate_hz;
    double vibration; /* common, relative standard deviation */
    double tone;      /* common, amplitude in deg/s */
    double tone_hz;
    double shaken[DAVAR_SELECT_AXES]; /* the last vibration */
    double shake;                     /* angular acceleration, deg/s^2, standard deviation */
    double turn[DAVAR_SELECT_AXES];
    double rate[DAVAR_SELECT_AXES];
    uint64_t samples;
} flight_t;

/* Box-Muller, both numbers. */
static inline double flight_gauss(flight_t *flight)
{
    flight->has_gauss = !flight->has_gauss;
    if (!flight->has_gauss) {
        return flight->gauss;
    }
    const double radius = sqrt(-2.0 * log(random_uniform(&flight->random)));
    const double angle = 6.283185307179586 * random_uniform(&flight->random);
    flight->gauss = radius * sin(angle);
    return radius * cos(angle);
}

static inline double flight_bounded(flight_t *flight, double sigma)
{
    const double value = flight_gauss(flight);
    return sigma * ((value > 2.0) ? 2.0 : ((value < -2.0) ? -2.0 : value));
}

/* A flight of healthy gyros of relative noise 1, at rest. Any two of them differ by no more than
 * the tolerances of the configuration. */
static inline void flight_start(flight_t *flight, uint64_t seed,
                                const davar_select_config_t *config, flight_noise_t kind)
{
    memset(flight, 0, sizeof *flight);
    flight->random = random_seeded(seed);
    flight->gyros = config->gyros;
    flight->axes = config->axes;
    flight->rate_hz = (double)config->rate_hz;
    flight->kind = kind;
    for (uint32_t i = 0U; i < flight->gyros; i++) {
        flight->own[i] = 1.0;
        flight->scale[i] = 1.0 + flight_bounded(flight, 0.25 * (double)config->scale_tolerance);
        flight->delay_s[i] = flight_bounded(flight, 0.25 * (double)config->time_tolerance_s);
        flight->heat[i] = 0.1 * flight_gauss(flight);
        for (uint32_t a = 0U; a < flight->axes; a++) {
            flight->bias[i][a] = 0.3 * flight_gauss(flight);
        }
    }
}

/* Of variance 1, except for the steps of NOISE_MARKOV_STEP. */
static inline double flight_noise(flight_t *flight, uint32_t i, uint32_t a)
{
    double *const state = &flight->state[i][a];
    switch (flight->kind) {
    case NOISE_LAPLACE: {
        const double u = random_uniform(&flight->random) - 0.5;
        return ((u < 0.0) ? 0.7071 : -0.7071) * log(1.0 - (2.0 * fabs(u)));
    }
    case NOISE_STUDENT_5: { /* Bailey 1994; the variance of Student t is 5/3 */
        const double radius = 3.0 * (pow(random_uniform(&flight->random), -0.4) - 1.0);
        return sqrt(radius) * cos(6.283185307179586 * random_uniform(&flight->random));
    }
    case NOISE_MARKOV:
        *state = (0.7 * *state) + (0.7141 * flight_gauss(flight));
        return *state;
    case NOISE_MARKOV_STEP:
        *state = (0.7 * *state) + (0.7141 * flight_gauss(flight));
        flight->held[i][a] = (0.999 * flight->held[i][a]) + *state;
        return flight->held[i][a];
    case NOISE_HELD:
        if ((flight->samples % 3U) == 0U) {
            *state = flight_gauss(flight);
        }
        return *state;
    case NOISE_GAUSS:
    default:
        return flight_gauss(flight);
    }
}

static inline void flight_sample(flight_t *flight, float *rates)
{
    const double pi_2 = 6.283185307179586;
    const double dt = 1.0 / flight->rate_hz;
    const double warmth = 1.0 - exp(-(double)flight->samples * dt / 300.0);
    for (uint32_t a = 0U; a < flight->axes; a++) {
        double turn = 0.0;
        if (flight->shake > 0.0) {
            const double kept = exp(-5.0 * dt); /* 0.2 s */
            flight->turn[a] = (kept * flight->turn[a]) +
                              (flight->shake * sqrt(1.0 - (kept * kept)) * flight_gauss(flight));
            flight->rate[a] = ((1.0 - dt) * flight->rate[a]) + (flight->turn[a] * dt);
            turn = flight->turn[a];
        }
        const double common = (flight->vibration > 0.0)
                                  ? (flight->vibration * FLIGHT_SIGMA * flight_gauss(flight))
                                  : 0.0;
        const double whip = (common - flight->shaken[a]) / dt;
        const double phase = (pi_2 * flight->tone_hz * (double)flight->samples * dt) + a;
        flight->shaken[a] = common;
        for (uint32_t i = 0U; i < flight->gyros; i++) {
            const double delay = flight->delay_s[i];
            const double tone = (flight->tone > 0.0)
                                    ? (flight->tone * sin(phase - (pi_2 * flight->tone_hz * delay)))
                                    : 0.0;
            const double rate = flight->rate[a] + common + tone - (delay * (turn + whip));
            rates[(i * flight->axes) + a] =
                (float)((flight->scale[i] * rate) + flight->bias[i][a] +
                        (flight->heat[i] * warmth) +
                        (FLIGHT_SIGMA * flight->own[i] * flight_noise(flight, i, a)));
        }
    }
    flight->samples++;
}

#endif
