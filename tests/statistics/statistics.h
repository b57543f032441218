/* davar-statistics - what an experiment reports, what of it must hold, and the score of windows that
 * most experiments share. */
#ifndef DAVAR_TESTS_STATISTICS_H
#define DAVAR_TESTS_STATISTICS_H

#include "davar/davar.h"
#include "davar/fit.h"
#include "gyro_noise.h"

#include <math.h>
#include <stdio.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* One simulation for each row of a table. */
typedef struct {
    const void *rows;
    size_t row_size;
    size_t count;
    void (*run)(const void *row, unsigned trials, uint64_t seed);
} experiment_t;

#define ROWS(rows) rows, sizeof(rows)[0], COUNT_OF(rows)

#define EXPERIMENT(name, ...) extern const experiment_t name##_experiment;
#include "experiments.inc"
#undef EXPERIMENT

/* ---- the instance that every experiment starts anew ---- */

extern davar_config_t config;
extern davar_t davar;
extern davar_plan_t plan;
extern davar_result_t result;
extern uint64_t memory[131072];

/* Octaves for the longest window at 1 Hz, a unit per count, and windows without moments. */
void configure(const davar_law_t *law, uint32_t shortest, uint32_t longest, uint32_t stride);

#define START(type)                                                                                \
    require(davar_init_##type(&davar, &config, memory, sizeof memory) == DAVAR_OK, "init")

/* ---- figures ---- */

#define STANDARD_ERRORS 3.0 /* of a figure, beyond a limit */

/* A share in percent of `trials` independent ones. */
void share(const char *name, double hits, double trials);
/* Events over the stated ones. */
void rate(const char *name, double events, double stated);
/* Any number with its standard error. */
void value(const char *name, double number, double error);

/* Names the next reports. */
__attribute__((format(printf, 1, 2))) void label(const char *format, ...);

/* Prints the figures since the last report. `holds` has limits of some of them: "N 94:97, extra :3".
 * Each figure of this name must be within, or outside by at most three standard errors. After
 * `?` the figure may have too few trials to be judged ("N? 94:"). */
void report(const char *holds);

/* Ends the program. */
void require(bool is_met, const char *what);

/* ---- the score of windows ---- */

#define LONGEST 6000U /* window */
#define WIDTHS 4096U

typedef struct {
    double windows;
    double taken[DAVAR_TAUS_MAX]; /* windows that have this cluster size */
    double adev[DAVAR_TAUS_MAX];  /* ... and whose interval contains the true value */
    bool is_long[DAVAR_TAUS_MAX]; /* above a ninth of the window */
    double given[DAVAR_COEFFICIENT_COUNT];
    double within[DAVAR_COEFFICIENT_COUNT]; /* of these, the interval contains the true value */
    double held[DAVAR_COEFFICIENT_COUNT];   /* interval or upper limit contain it */
    double extra;                           /* windows with a term that is not there */
    double withheld;                        /* windows that may be filtered */
    double error[2];                        /* of N, relative: sum, and sum of squares */
    double width[WIDTHS];                   /* high over low of N */
} score_t;

bool contains(double low, double high, double truth);

/* adev: the true Allan deviations, or NULL. */
void score_add(score_t *score, const davar_result_t *found, const double truth[],
               const double adev[]);

/* Reports the score: ADEV and, above a ninth of the window, `long`; statements that hold for N and
 * for the `others`; N.given, Q.given and so on; N.within; extra; withheld; bias of N in percent; its
 * rms in units of `bound` percent; width (median). */
void score_report(const score_t *score, double bound, const char *holds);

/* In the units of the coefficients, at 1 Hz. */
void truth_of(const gyro_noise_t *noise, double truth[]);

/* Of a text such as "N 1 K 0.02": the terms Q, N, B, K and R, and F, the cutoff of one pole. */
gyro_noise_t noise_of(const char *text);

/* Of white noise of N = 1. */
extern const double truth_1[DAVAR_COEFFICIENT_COUNT];

/* Fills the Allan deviations of `result` by brute force. */
void observe(const double samples[], uint32_t window);

/* Prepares `result` for sizes m[] of a window without gaps. */
void expect_window(uint32_t window, const uint32_t m[], uint8_t count);

int ascending(const void *a, const void *b);

#endif
