/* davar tests - rate records with a known Allan variance. */
#include "gyro_noise.h"

/* Gauss-Markov processes of equal variance s^2, a factor of four apart in time constant, add up to flicker with the
 * plateau s^2 (the avar of one, integrated over ln Tc, is s^2 ln 4). The shortest one gets a fifth: it stands for
 * all that are shorter still, which look white. The plateau is then flat within 2 % from m = 2 on. */
#define MARKOV_COUNT 12
#define MARKOV_RATIO 4.0
#define MARKOV_FIRST 0.25
#define MARKOV_FIRST_SHARE 0.2

static double markov_memory(int index) /* exp(-1 / Tc) */
{
    return exp(-1.0 / (MARKOV_FIRST * pow(MARKOV_RATIO, index)));
}

static double markov_variance(const gyro_noise_t *noise, int index)
{
    const double plateau = noise->flicker * noise->flicker * 2.0 * log(2.0) / acos(-1.0);
    return plateau * ((index == 0) ? MARKOV_FIRST_SHARE : 1.0);
}

static void add_flicker(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    for (int k = 0; k < MARKOV_COUNT; k++) {
        const double sigma = sqrt(markov_variance(noise, k));
        const double memory = markov_memory(k);
        const double drive = sigma * sqrt(1.0 - memory * memory);
        double state = sigma * random_gauss(random);
        for (size_t i = 0; i < count; i++) {
            rate[i] += state;
            state = memory * state + drive * random_gauss(random);
        }
    }
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

/* The walk goes on between the samples, and a sample is its mean: half the step, and the bridge's own area. */
static void add_drift(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
{
    double walk = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double step = (noise->walk > 0.0) ? noise->walk * random_gauss(random) : 0.0;
        const double area = (noise->walk > 0.0) ? noise->walk * sqrt(1.0 / 12.0) * random_gauss(random) : 0.0;
        rate[i] += walk + 0.5 * step + area + noise->ramp * (double)i;
        walk += step;
    }
}

static void add_quantization(const gyro_noise_t *noise, random_t *random, double *rate, size_t count)
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

/* avar(m) of a stationary process with autocovariance memory^k. */
static double markov_avar(double memory, unsigned m)
{
    double sum = 2.0 * (double)m;
    double power = 1.0;
    for (unsigned k = 1; k < 2U * m; k++) {
        power *= memory;
        const double kernel = (k <= m) ? 2.0 * (double)m - 3.0 * (double)k : (double)k - 2.0 * (double)m;
        sum += 2.0 * power * kernel;
    }
    return sum / (2.0 * (double)m * (double)m);
}

static double white_avar(const gyro_noise_t *noise, unsigned m)
{
    const double square = noise->white * noise->white;
    const double gain = noise->low_pass;
    return (gain > 0.0) ? square * gain / (2.0 - gain) * markov_avar(1.0 - gain, m) : square / (double)m;
}

double gyro_noise_avar(const gyro_noise_t *noise, unsigned m)
{
    const double tau = (double)m;
    double sum = white_avar(noise, m);
    sum += 3.0 * noise->quantization * noise->quantization / (tau * tau);
    sum += noise->walk * noise->walk * tau / 3.0;
    sum += 0.5 * noise->ramp * noise->ramp * tau * tau;
    for (int k = 0; k < MARKOV_COUNT; k++) {
        sum += markov_variance(noise, k) * markov_avar(markov_memory(k), m);
    }
    return sum;
}
