/* davar bench - the program around the methods of one C file: samples in, answers out.
 *
 * A method NAME has a type NAME_t and the functions NAME_start, NAME_push, NAME_gap (samples
 * were lost before the next one) and NAME_take (the answer now). METHOD makes its loop, and PROGRAM makes main from a list of
 * methods:
 *
 *   FILE list                                  a line per method: name, bytes of state
 *   FILE run NAME RATE LSB CUTOFF SHEET        answers to int16 samples on standard input, as doubles
 *   FILE push|take NAME RATE LSB CUTOFF SHEET  least ns per sample of nine runs, without or with answers */
#ifndef DAVAR_BENCH_METHOD_H
#define DAVAR_BENCH_METHOD_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define STRIDE 10U     /* samples between answers */
#define LOST INT16_MIN /* a sample that is missing */
#define RUNS 9U
#define SAMPLES_MAX 4000000U

/* What is known about the gyro. */
typedef struct {
    double rate_hz;
    double lsb_dps;
    double cutoff;    /* of a digital Butterworth low-pass of two poles, over the rate; 0: white
                         noise, negative: unknown */
    double sheet_dps; /* standard deviation of a sample of white noise, from the data sheet */
} setup_t;

/* NaN: none. */
typedef struct {
    double sigma_dps; /* standard deviation of a sample of white noise */
    double low_dps;   /* 95 % interval */
    double high_dps;
    double alarm; /* 1: the noise has changed, or the gyro is not at rest */
} answer_t;

static inline answer_t only_sigma(double sigma_dps)
{
    return (answer_t){sigma_dps, (double)NAN, (double)NAN, (double)NAN};
}

static inline answer_t only_alarm(bool alarm)
{
    return (answer_t){(double)NAN, (double)NAN, (double)NAN, alarm ? 1.0 : 0.0};
}

static inline double now_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (1e9 * (double)time.tv_sec) + (double)time.tv_nsec;
}

typedef double (*run_t)(const setup_t *setup, const int16_t *x, size_t count, answer_t *answers);

typedef struct {
    const char *name;
    size_t bytes;
    run_t run;
} method_t;

/* answers: one for each STRIDE samples; null: none is taken. */
#define METHOD(NAME)                                                                               \
    static double NAME##_run(const setup_t *setup, const int16_t *x, size_t count,                 \
                             answer_t *answers)                                                    \
    {                                                                                              \
        static NAME##_t state;                                                                     \
        uint32_t missing = 0U;                                                                     \
        memset(&state, 0, sizeof state);                                                           \
        NAME##_start(&state, setup);                                                               \
        const double start = now_ns();                                                             \
        for (size_t first = 0; (first + STRIDE) <= count; first += STRIDE) {                       \
            for (size_t i = first; i < (first + STRIDE); i++) {                                    \
                if (x[i] == LOST) {                                                                \
                    missing++;                                                                     \
                    continue;                                                                      \
                }                                                                                  \
                if (missing > 0U) {                                                                \
                    NAME##_gap(&state, missing);                                                   \
                    missing = 0U;                                                                  \
                }                                                                                  \
                NAME##_push(&state, x[i]);                                                         \
            }                                                                                      \
            if (answers != NULL) {                                                                 \
                answers[first / STRIDE] = NAME##_take(&state);                                     \
            }                                                                                      \
        }                                                                                          \
        return now_ns() - start;                                                                   \
    }

/* A method that does not know of lost samples. */
#define METHOD_WITHOUT_GAPS(NAME)                                                                  \
    static void NAME##_gap(const NAME##_t *state, uint32_t missing)                                \
    {                                                                                              \
        (void)state;                                                                               \
        (void)missing;                                                                             \
    }                                                                                              \
    METHOD(NAME)

#define PROGRAM(...)                                                                               \
    int main(int argc, char **argv)                                                                \
    {                                                                                              \
        const method_t methods[] = {__VA_ARGS__};                                                  \
        return program(methods, sizeof methods / sizeof methods[0], argc, argv);                   \
    }

static int list(const method_t *methods, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        printf("%s\t%zu\n", methods[i].name, methods[i].bytes);
    }
    return 0;
}

static double least_ns(const method_t *method, const setup_t *setup, const int16_t *x, size_t count,
                       answer_t *answers)
{
    double least = (double)INFINITY;
    for (unsigned i = 0; i < RUNS; i++) {
        least = fmin(least, method->run(setup, x, count, answers));
    }
    return least / (double)count;
}

static int program(const method_t *methods, size_t count, int argc, char **argv)
{
    static int16_t x[SAMPLES_MAX];
    static answer_t answers[SAMPLES_MAX / STRIDE];
    if ((argc == 2) && (strcmp(argv[1], "list") == 0)) {
        return list(methods, count);
    }
    for (size_t i = 0; (argc == 7) && (i < count); i++) {
        if (strcmp(argv[2], methods[i].name) != 0) {
            continue;
        }
        const setup_t setup = {strtod(argv[3], NULL), strtod(argv[4], NULL), strtod(argv[5], NULL),
                               strtod(argv[6], NULL)};
        const size_t samples = fread(x, sizeof x[0], SAMPLES_MAX, stdin);
        if (strcmp(argv[1], "run") == 0) {
            (void)methods[i].run(&setup, x, samples, answers);
            (void)fwrite(answers, sizeof answers[0], samples / STRIDE, stdout);
        } else {
            printf("%.9g\n", least_ns(&methods[i], &setup, x, samples,
                                      (strcmp(argv[1], "take") == 0) ? answers : NULL));
        }
        return 0;
    }
    fprintf(stderr, "usage: %s list | run|push|take METHOD RATE LSB CUTOFF SHEET\n", argv[0]);
    return 2;
}

#endif
