/* davar tests - Gaussian noise after a filter as an endless stream, fast: some 10 ns a sample. */
#ifndef DAVAR_TESTS_FILTERED_NOISE_H
#define DAVAR_TESTS_FILTERED_NOISE_H

#include "autocovariance.h"
#include "low_pass.h"
#include "random.h"

/* The ziggurat of Marsaglia and Tsang 2000 with 256 layers of equal area. */
typedef struct {
    double x[257]; /* right edges, the widest first */
    double f[257]; /* exp(-x^2 / 2) there */
} ziggurat_t;

#define ZIGGURAT_TAIL 3.6541528853610088
#define ZIGGURAT_AREA 0.00492867323399

static inline void ziggurat_start(ziggurat_t *ziggurat)
{
    double *const x = ziggurat->x;
    x[0] = ZIGGURAT_AREA / exp(-0.5 * ZIGGURAT_TAIL * ZIGGURAT_TAIL);
    x[1] = ZIGGURAT_TAIL;
    for (int i = 2; i < 256; i++) {
        x[i] = sqrt(-2.0 * log((ZIGGURAT_AREA / x[i - 1]) + exp(-0.5 * x[i - 1] * x[i - 1])));
    }
    x[256] = 0.0;
    for (int i = 0; i < 257; i++) {
        ziggurat->f[i] = exp(-0.5 * x[i] * x[i]);
    }
}

static inline double ziggurat_tail(random_t *random)
{
    for (;;) {
        const double a = -log(random_uniform(random)) / ZIGGURAT_TAIL;
        const double b = -log(random_uniform(random));
        if ((2.0 * b) >= (a * a)) {
            return ZIGGURAT_TAIL + a;
        }
    }
}

static inline double ziggurat_next(const ziggurat_t *ziggurat, random_t *random)
{
    for (;;) {
        const uint64_t bits = random_next(random);
        const unsigned i = (unsigned)(bits & 255U);
        const double sign = ((bits & 256U) != 0U) ? 1.0 : -1.0;
        const double x = (double)(bits >> 11U) * (1.0 / 9007199254740992.0) * ziggurat->x[i];
        if (x < ziggurat->x[i + 1U]) {
            return sign * x;
        }
        if (i == 0U) {
            return sign * ziggurat_tail(random);
        }
        const double height = ziggurat->f[i] - ziggurat->f[i + 1U];
        const double at = ziggurat->f[i + 1U] + (random_uniform(random) * height);
        if (at > exp(-0.5 * x * x)) {
            continue;
        }
        return sign * x;
    }
}

#define FILTERED_TAPS 64U

/* White noise whose samples have variance 1 after the filter. */
typedef struct {
    random_t random;
    ziggurat_t ziggurat;
    low_pass_t low_pass;
    double h[FILTERED_TAPS]; /* weights of the moving averages */
    double past[FILTERED_TAPS];
    unsigned taps;
    unsigned at;
    unsigned step; /* decimation */
    bool has_poles;
    bool has_two;
} filtered_noise_t;

static inline double filtered_noise_input(filtered_noise_t *noise, double size)
{
    const double first = ziggurat_next(&noise->ziggurat, &noise->random) * size;
    if (!noise->has_poles) {
        return first;
    }
    const double second =
        noise->has_two ? (ziggurat_next(&noise->ziggurat, &noise->random) * size) : 0.0;
    return low_pass_advance(&noise->low_pass, 0.0, first, second);
}

/* The next sample; `size` times the noise comes in now. */
static inline double filtered_noise_next(filtered_noise_t *noise, double size)
{
    if (noise->taps == 1U) {
        return filtered_noise_input(noise, size);
    }
    for (unsigned i = 0U; i < noise->step; i++) {
        noise->past[noise->at % FILTERED_TAPS] = filtered_noise_input(noise, size);
        noise->at++;
    }
    double sum = 0.0;
    for (unsigned i = 0U; i < noise->taps; i++) {
        sum += noise->h[i] * noise->past[(noise->at - 1U - i) % FILTERED_TAPS];
    }
    return sum;
}

static inline void filtered_noise_start(filtered_noise_t *noise, const shape_t *filter,
                                        uint64_t seed)
{
    static double h[AUTOCOVARIANCE_LAGS];
    memset(noise, 0, sizeof *noise);
    noise->random = random_seeded(seed);
    ziggurat_start(&noise->ziggurat);
    noise->low_pass = low_pass_of(filter, shape_decimation(filter));
    noise->has_poles = (filter->poles > 0U);
    noise->has_two = (filter->poles == 2U);
    noise->step = (unsigned)shape_decimation(filter);
    noise->taps = (unsigned)impulse_response(filter, h);
    double squares = 0.0;
    for (unsigned i = 0U; i < noise->taps; i++) {
        squares += h[i] * h[i];
    }
    for (unsigned i = 0U; i < noise->taps; i++) {
        noise->h[i] = h[i] / sqrt(squares);
    }
    for (unsigned i = 0U; i < 2000U; i++) {
        (void)filtered_noise_next(noise, 1.0);
    }
}

#endif
