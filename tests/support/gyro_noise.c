/* davar tests - rate records with a known Allan variance. */
#include "gyro_noise.h"

/* Gauss-Markov processes of equal variance s^2, a factor of four apart in time constant, add up to
 * flicker with the plateau s^2 (the avar of one, integrated over ln Tc, is s^2 ln 4): flat within 1
 * % far inside the range. */
#define MARKOV_COUNT 16
#define MARKOV_FIRST 0.001
#define MARKOV_RATIO 4.0

typedef struct {
    double sigma;  /* of the state */
    double time;   /* Tc, samples */
    double memory; /* exp(-1 / Tc) */
    double mean;   /* of the next sample, given the state 1 */
} markov_t;

static markov_t markov_process(const gyro_noise_t *noise, int index)
{
    markov_t markov;
    markov.sigma = noise->flicker * sqrt(2.0 * log(2.0) / acos(-1.0));
    markov.time = MARKOV_FIRST * pow(MARKOV_RATIO, index);
    markov.memory = exp(-1.0 / markov.time);
    markov.mean = -expm1(-1.0 / markov.time) * markov.time;
    return markov;
}

/* Variance of a sample (the mean of the process over it) given the state at its start; the series
 * where it cancels. */
static double markov_sample_variance(const markov_t *markov)
{
    const double a = 1.0 / markov->time;
    const double e = markov->memory;
    const double bracket = (a < 1e-3) ? a * a * a * (2.0 / 3.0) : 2.0 * a - 3.0 + 4.0 * e - e * e;
    return markov->sigma * markov->sigma * bracket / (a * a);
}

/* State and sample advance together: their noise is correlated. Adds what they share, and returns
 * the variance of the rest, which is independent from sample to sample. */
static double add_markov(const markov_t *markov, random_t *random, double *rate, size_t count)
{
    const double step = markov->sigma * sqrt(1.0 - markov->memory * markov->memory);
    const double covariance =
        markov->sigma * markov->sigma * markov->mean * markov->mean / markov->time;
    const double shared = covariance / step;
    double state = markov->sigma * random_gauss(random);
    for (size_t i = 0; i < count; i++) {
        const double drive = random_bell(random);
        rate[i] += markov->mean * state + shared * drive;
        state = markov->memory * state + step * drive;
    }
    return fmax(0.0, markov_sample_variance(markov) - shared * shared);
}

static void add_flicker(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    double rest = 0.0;
    for (int k = 0; k < MARKOV_COUNT; k++) {
        const markov_t markov = markov_process(noise, k);
        rest += add_markov(&markov, random, rate, count);
    }
    const double own = sqrt(rest);
    for (size_t i = 0; i < count; i++) {
        rate[i] += own * random_bell(random);
    }
}

/* The Allan variance of a Gauss-Markov process (IEEE Std 952) with (q Tc)^2 = 2 s^2 Tc; the series
 * where it cancels. */
static double markov_avar(const markov_t *markov, double tau)
{
    const double x = tau / markov->time;
    const double e = exp(-x);
    const double bracket = (x < 1e-3) ? x * x / 3.0 : 1.0 - (3.0 - 4.0 * e + e * e) / (2.0 * x);
    return 2.0 * markov->sigma * markov->sigma * bracket / x;
}

static void add_white(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    const double gain = (noise->low_pass > 0.0) ? noise->low_pass : 1.0;
    double state = noise->white * sqrt(gain / (2.0 - gain)) * random_gauss(random);
    for (size_t i = 0; i < count; i++) {
        state += gain * (noise->white * random_gauss(random) - state);
        rate[i] += state;
    }
}

/* The walk continues between the samples, and a sample is its mean: half the step, and the bridge's
 * own area. */
static void add_drift(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    double walk = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double step = (noise->walk > 0.0) ? noise->walk * random_gauss(random) : 0.0;
        const double area =
            (noise->walk > 0.0) ? noise->walk * sqrt(1.0 / 12.0) * random_gauss(random) : 0.0;
        rate[i] += walk + 0.5 * step + area + noise->ramp * (double)i;
        walk += step;
    }
}

static void add_quantization(const gyro_noise_t *noise, random_t *random, double *rate,
                             size_t count)
{
    double before = random_gauss(random);
    for (size_t i = 0; i < count; i++) {
        const double after = random_gauss(random);
        rate[i] += noise->quantization * (after - before);
        before = after;
    }
}

void gyro_noise_fill(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        rate[i] = 0.0;
    }
    add_white(noise, random, rate, count);
    add_drift(noise, random, rate, count);
    if (noise->flicker > 0.0) {
        add_flicker(noise, random, rate, count);
    }
    if (noise->quantization > 0.0) {
        add_quantization(noise, random, rate, count);
    }
}

/* avar(m) of a process of variance 1 with autocovariance memory^k. */
static double filtered_avar(double memory, unsigned m)
{
    double sum = 2.0 * (double)m;
    double power = 1.0;
    for (unsigned k = 1; k < 2U * m; k++) {
        power *= memory;
        const double kernel =
            (k <= m) ? 2.0 * (double)m - 3.0 * (double)k : (double)k - 2.0 * (double)m;
        sum += 2.0 * power * kernel;
    }
    return sum / (2.0 * (double)m * (double)m);
}

static double white_avar(const gyro_noise_t *noise, unsigned m)
{
    const double square = noise->white * noise->white;
    const double gain = noise->low_pass;
    return (gain > 0.0) ? square * gain / (2.0 - gain) * filtered_avar(1.0 - gain, m)
                        : square / (double)m;
}

double gyro_noise_avar(const gyro_noise_t *noise, unsigned m)
{
    const double tau = (double)m;
    double sum = white_avar(noise, m);
    sum += 3.0 * noise->quantization * noise->quantization / (tau * tau);
    sum += noise->walk * noise->walk * tau / 3.0;
    sum += 0.5 * noise->ramp * noise->ramp * tau * tau;
    for (int k = 0; k < MARKOV_COUNT; k++) {
        const markov_t markov = markov_process(noise, k);
        sum += (noise->flicker > 0.0) ? markov_avar(&markov, tau) : 0.0;
    }
    return sum;
}
