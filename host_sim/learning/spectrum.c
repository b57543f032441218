/* davar-sim - spectra of segments: a straight line is removed, then a Hann window keeps drifts out
 * of the higher frequencies. */
#include "learning/spectrum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979324
#define LN_2 0.693147180559945309

/* A segment moves if its power exceeds that of a quiet one by this factor. */
#define MOVES 4.0F

/* A record of at least so many long segments is read in long ones. */
#define LONG_ONES 33U

/* Segments in the record. */
static uint64_t all_places(const spectrum_t *spectrum, uint64_t samples)
{
    const uint64_t n = spectrum->segment;
    return (samples < n) ? 0U : (((samples - n) / (n / 2U)) + 1U);
}

size_t spectrum_places(const spectrum_t *spectrum, uint64_t samples)
{
    const uint64_t all = all_places(spectrum, samples);
    return (all < SPECTRUM_SEGMENTS) ? (size_t)all : SPECTRUM_SEGMENTS;
}

uint64_t spectrum_place(const spectrum_t *spectrum, uint64_t samples, size_t i)
{
    const uint64_t all = all_places(spectrum, samples);
    return (spectrum->segment / 2U) *
           ((all <= SPECTRUM_SEGMENTS) ? i : (i * all / SPECTRUM_SEGMENTS));
}

bool spectrum_open(spectrum_t *spectrum, uint64_t samples)
{
    *spectrum = (spectrum_t){.segment = SPECTRUM_LONG};
    if (all_places(spectrum, samples) < LONG_ONES) {
        spectrum->segment = SPECTRUM_SHORT;
    }
    spectrum->ordinates = (spectrum->segment / 2U) - 1U;
    spectrum->power = malloc(sizeof(float) * SPECTRUM_SEGMENTS * spectrum->ordinates);
    return spectrum->power != NULL;
}

void spectrum_close(spectrum_t *spectrum)
{
    free(spectrum->power);
    *spectrum = (spectrum_t){0};
}

typedef struct {
    double re;
    double im;
} point_t;

/* Subtracts the straight line that fits best and applies the window. */
static void shape(const double *samples, size_t n, point_t shaped[])
{
    double mean = 0.0;
    double slope = 0.0;
    double squares = 0.0;
    for (size_t i = 0; i < n; i++) {
        const double at = (double)i - 0.5 * (double)(n - 1U);
        mean += samples[i] / (double)n;
        slope += at * samples[i];
        squares += at * at;
    }
    for (size_t i = 0; i < n; i++) {
        const double at = (double)i - 0.5 * (double)(n - 1U);
        const double window = 1.0 - cos(2.0 * PI * (double)i / (double)n);
        shaped[i] = (point_t){window * (samples[i] - mean - (slope / squares * at)), 0.0};
    }
}

/* Moves each point to the index with the bits of its own in reverse order. */
static void reverse(point_t x[], size_t n)
{
    size_t to = 0U;
    for (size_t i = 0U; i < n; i++) {
        if (i < to) {
            const point_t kept = x[i];
            x[i] = x[to];
            x[to] = kept;
        }
        size_t bit = n / 2U;
        for (; (bit > 0U) && ((to & bit) != 0U); bit /= 2U) {
            to &= ~bit;
        }
        to |= bit;
    }
}

/* The fast Fourier transform of Cooley and Tukey; n is a power of two. */
static void transform(point_t x[], size_t n)
{
    reverse(x, n);
    for (size_t half = 1U; half < n; half *= 2U) {
        for (size_t k = 0U; k < half; k++) {
            const double angle = -PI * (double)k / (double)half;
            const double re = cos(angle);
            const double im = sin(angle);
            for (size_t i = k; i < n; i += 2U * half) {
                point_t *const other = &x[i + half];
                const point_t turned = {other->re * re - other->im * im,
                                        other->re * im + other->im * re};
                *other = (point_t){x[i].re - turned.re, x[i].im - turned.im};
                x[i] = (point_t){x[i].re + turned.re, x[i].im + turned.im};
            }
        }
    }
}

void spectrum_add(spectrum_t *spectrum, const double *samples)
{
    point_t x[SPECTRUM_LONG];
    if (spectrum->count == SPECTRUM_SEGMENTS) {
        return;
    }
    float *power = spectrum->power + spectrum->count * spectrum->ordinates;
    shape(samples, spectrum->segment, x);
    transform(x, spectrum->segment);
    for (size_t j = 1; j <= spectrum->ordinates; j++) {
        const double square = (x[j].re * x[j].re) + (x[j].im * x[j].im);
        power[j - 1U] = (float)(square / (1.5 * (double)spectrum->segment));
    }
    spectrum->count++;
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a;
    const float y = *(const float *)b;
    return (x > y) - (x < y);
}

static float total(const spectrum_t *spectrum, size_t segment)
{
    const float *const power = spectrum->power + segment * spectrum->ordinates;
    float sum = 0.0F;
    for (size_t j = 0; j < spectrum->ordinates; j++) {
        sum += power[j];
    }
    return sum;
}

/* Keeps the segments at rest, and returns their number. */
static size_t keep_quiet(spectrum_t *spectrum)
{
    float sorted[SPECTRUM_SEGMENTS] = {0};
    for (size_t s = 0; s < spectrum->count; s++) {
        sorted[s] = total(spectrum, s);
    }
    qsort(sorted, spectrum->count, sizeof sorted[0], compare);
    const float most = MOVES * sorted[spectrum->count / 4U];
    size_t kept = 0;
    for (size_t s = 0; s < spectrum->count; s++) {
        if (total(spectrum, s) <= most) {
            const size_t m = spectrum->ordinates;
            memmove(spectrum->power + kept * m, spectrum->power + s * m, sizeof(float) * m);
            kept++;
        }
    }
    return (most > 0.0F) ? kept : 0U;
}

size_t spectrum_median(spectrum_t *spectrum, double power[SPECTRUM_MOST])
{
    float sorted[SPECTRUM_SEGMENTS];
    const size_t count = (spectrum->count > 0U) ? keep_quiet(spectrum) : 0U;
    for (size_t j = 0; (count > 0U) && (j < spectrum->ordinates); j++) {
        for (size_t s = 0; s < count; s++) {
            sorted[s] = spectrum->power[s * spectrum->ordinates + j];
        }
        qsort(sorted, count, sizeof sorted[0], compare);
        const double middle =
            0.5 * ((double)sorted[(count - 1U) / 2U] + (double)sorted[count / 2U]);
        power[j] = middle / LN_2; /* the median of chi-square over its mean, with 2 degrees */
    }
    return count;
}
