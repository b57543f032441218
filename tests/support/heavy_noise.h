/* davar tests - white noise of variance 1 with light and heavy tails, and one that is not white, as
 * endless streams: 10 to 60 ns per sample. */
#ifndef DAVAR_TESTS_HEAVY_NOISE_H
#define DAVAR_TESTS_HEAVY_NOISE_H

#include "filtered_noise.h"

typedef struct {
    random_t random;
    ziggurat_t ziggurat;
    double before; /* AR(1) */
} source_t;

static inline source_t source_seeded(uint64_t seed)
{
    source_t source = {.random = random_seeded(seed)};
    ziggurat_start(&source.ziggurat);
    return source;
}

static inline double noise_gauss(source_t *source)
{
    return ziggurat_next(&source->ziggurat, &source->random);
}

static inline double noise_uniform(source_t *source)
{
    return (random_uniform(&source->random) - 0.5) * sqrt(12.0);
}

static inline double noise_laplace(source_t *source)
{
    const double u = random_uniform(&source->random) - 0.5;
    return ((u < 0.0) ? 1.0 : -1.0) * log(1.0 - (2.0 * fabs(u))) * sqrt(0.5);
}

/* Student's t with three degrees of freedom: without a fourth moment. */
static inline double noise_student3(source_t *source)
{
    const double z = noise_gauss(source);
    const double two = -2.0 * log(random_uniform(&source->random)); /* chi-square */
    return z / sqrt(two + pow(noise_gauss(source), 2.0));
}

/* With four degrees of freedom: the fourth moment is only just infinite. */
static inline double noise_student4(source_t *source)
{
    const double z = noise_gauss(source);
    const double first = random_uniform(&source->random);
    return z / sqrt(-log(first * random_uniform(&source->random)));
}

/* With five degrees of freedom: kurtosis 9. */
static inline double noise_student5(source_t *source)
{
    const double z = noise_gauss(source);
    const double first = random_uniform(&source->random);
    const double four = -2.0 * log(first * random_uniform(&source->random)); /* chi-square */
    return z * sqrt(3.0 / (four + pow(noise_gauss(source), 2.0)));
}

/* One sample in twenty is five times as large: kurtosis 20. */
static inline double noise_mixed(source_t *source)
{
    const double z = noise_gauss(source);
    return z * ((random_uniform(&source->random) < 0.05) ? 5.0 : 1.0) / sqrt(2.2);
}

/* One sample in a hundred is ten times as large: kurtosis 77. */
static inline double noise_rare10(source_t *source)
{
    const double z = noise_gauss(source);
    return z * ((random_uniform(&source->random) < 0.01) ? 10.0 : 1.0) / sqrt(1.99);
}

/* One sample in 500 is twenty times as large: kurtosis 298. */
static inline double noise_rare20(source_t *source)
{
    const double z = noise_gauss(source);
    return z * ((random_uniform(&source->random) < 0.002) ? 20.0 : 1.0) / sqrt(1.798);
}

/* Correlated: 0.5 from one sample to the next. */
static inline double noise_ar(source_t *source)
{
    source->before = (0.5 * source->before) + (sqrt(0.75) * noise_gauss(source));
    return source->before;
}

typedef struct {
    const char *name;
    double (*next)(source_t *source);
} noise_kind_t;

static const noise_kind_t noise_kinds[] = {{"gauss", noise_gauss},
                                           {"uniform", noise_uniform},
                                           {"laplace", noise_laplace},
                                           {"student5", noise_student5},
                                           {"student3", noise_student3},
                                           {"mixed", noise_mixed},
                                           {"ar", noise_ar},
                                           {"student4", noise_student4},
                                           {"rare10", noise_rare10},
                                           {"rare20", noise_rare20}};

#define NOISE_KINDS (sizeof noise_kinds / sizeof noise_kinds[0])
#define NOISE_WHITE_KINDS 6U /* the first, which the goals name */

#endif
