/* davar-sim - spectra of segments: a straight line is removed, then a Hann window keeps drifts out
 * of the higher frequencies. */
#include "learning/spectrum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define N SPECTRUM_SEGMENT
#define M SPECTRUM_ORDINATES
#define PI 3.14159265358979324
#define LN_2 0.693147180559945309

/* A segment moves if its power exceeds that of a quiet one by this factor. */
#define MOVES 4.0F

/* Segments in the record. */
static uint64_t all_places(uint64_t samples)
{
    return (samples < N) ? 0U : (((samples - N) / (N / 2U)) + 1U);
}

size_t spectrum_places(uint64_t samples)
{
    const uint64_t all = all_places(samples);
    return (all < SPECTRUM_SEGMENTS) ? (size_t)all : SPECTRUM_SEGMENTS;
}

uint64_t spectrum_place(uint64_t samples, size_t i)
{
    const uint64_t all = all_places(samples);
    return (N / 2U) * ((all <= SPECTRUM_SEGMENTS) ? i : (i * all / SPECTRUM_SEGMENTS));
}

bool spectrum_open(spectrum_t *spectrum)
{
    *spectrum = (spectrum_t){.power = malloc(sizeof(float) * SPECTRUM_SEGMENTS * M)};
    return spectrum->power != NULL;
}

void spectrum_close(spectrum_t *spectrum)
{
    free(spectrum->power);
    *spectrum = (spectrum_t){0};
}

/* Subtracts the straight line that fits best and applies the window. */
static void shape(const double *samples, double shaped[N])
{
    double mean = 0.0;
    double slope = 0.0;
    double squares = 0.0;
    for (size_t i = 0; i < N; i++) {
        const double at = (double)i - 0.5 * (double)(N - 1U);
        mean += samples[i] / (double)N;
        slope += at * samples[i];
        squares += at * at;
    }
    for (size_t i = 0; i < N; i++) {
        const double at = (double)i - 0.5 * (double)(N - 1U);
        const double window = 1.0 - cos(2.0 * PI * (double)i / (double)N);
        shaped[i] = window * (samples[i] - mean - (slope / squares * at));
    }
}

void spectrum_add(spectrum_t *spectrum, const double *samples)
{
    if (spectrum->count == SPECTRUM_SEGMENTS) {
        return;
    }
    float *power = spectrum->power + spectrum->count * M;
    double shaped[N];
    double cosine[N];
    shape(samples, shaped);
    for (size_t i = 0; i < N; i++) {
        cosine[i] = cos(2.0 * PI * (double)i / (double)N);
    }
    for (size_t j = 1; j <= M; j++) {
        double re = 0.0;
        double im = 0.0;
        for (size_t i = 0; i < N; i++) {
            re += shaped[i] * cosine[(i * j) % N];
            im += shaped[i] * cosine[((i * j) + (N / 4U)) % N];
        }
        power[j - 1U] = (float)(((re * re) + (im * im)) / (1.5 * (double)N));
    }
    spectrum->count++;
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a;
    const float y = *(const float *)b;
    return (x > y) - (x < y);
}

static float total(const float *power)
{
    float sum = 0.0F;
    for (size_t j = 0; j < M; j++) {
        sum += power[j];
    }
    return sum;
}

/* Keeps the segments at rest, and returns their number. */
static size_t keep_quiet(spectrum_t *spectrum)
{
    float sorted[SPECTRUM_SEGMENTS] = {0};
    for (size_t s = 0; s < spectrum->count; s++) {
        sorted[s] = total(spectrum->power + s * M);
    }
    qsort(sorted, spectrum->count, sizeof sorted[0], compare);
    const float most = MOVES * sorted[spectrum->count / 4U];
    size_t kept = 0;
    for (size_t s = 0; s < spectrum->count; s++) {
        const float *power = spectrum->power + s * M;
        if (total(power) <= most) {
            memmove(spectrum->power + kept * M, power, sizeof(float) * M);
            kept++;
        }
    }
    return (most > 0.0F) ? kept : 0U;
}

size_t spectrum_median(spectrum_t *spectrum, double power[SPECTRUM_ORDINATES])
{
    float sorted[SPECTRUM_SEGMENTS];
    const size_t count = (spectrum->count > 0U) ? keep_quiet(spectrum) : 0U;
    for (size_t j = 0; (count > 0U) && (j < M); j++) {
        for (size_t s = 0; s < count; s++) {
            sorted[s] = spectrum->power[s * M + j];
        }
        qsort(sorted, count, sizeof sorted[0], compare);
        const double middle =
            0.5 * ((double)sorted[(count - 1U) / 2U] + (double)sorted[count / 2U]);
        power[j] = middle / LN_2; /* the median of chi-square over its mean, with 2 degrees */
    }
    return count;
}
