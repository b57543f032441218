/* davar - weighted least squares for avar(m) = sum a[k] m^(k - 2) over any of the five terms, and the variance of what comes
 * out. Knows nothing of noise: weights and covariances are its caller's. Private to stage [5]. */
#ifndef DAVAR_LEAST_SQUARES_H
#define DAVAR_LEAST_SQUARES_H

#include "davar/types.h"

/* Terms of a model: bit k for term k. */
static inline unsigned davar_term_bit(int term)
{
    return 1U << (unsigned)term;
}

static inline bool davar_has_term(unsigned terms, int term)
{
    return (terms & davar_term_bit(term)) != 0U;
}

typedef struct {
    double at[DAVAR_COEFFICIENT_COUNT][DAVAR_COEFFICIENT_COUNT];
} davar_matrix_t;

/* The normal equations of all five terms. Zero at the start, then davar_normal_add, then davar_normal_scale. */
typedef struct {
    int count;                                      /* of the Allan variances: no more terms can be told apart */
    double moment[2 * DAVAR_COEFFICIENT_COUNT - 1]; /* sum of W m^(p - 4): X' W X holds only these, at row + column */
    double right[DAVAR_COEFFICIENT_COUNT];          /* X' W avar, scaled */
    double scale[DAVAR_COEFFICIENT_COUNT];          /* makes the diagonal of X' W X 1: a = scale * solution */
} davar_normal_t;

/* Inverse over some of the terms: row i belongs to term[i], in ascending order. */
typedef struct {
    int size;
    int term[DAVAR_COEFFICIENT_COUNT];
    double at[DAVAR_COEFFICIENT_COUNT][DAVAR_COEFFICIENT_COUNT];
} davar_inverse_t;

/* One Allan variance; weight_per_m2: its weight over m^2. */
void davar_normal_add(davar_normal_t *normal, double m, double avar, double weight_per_m2);

/* All are added. */
void davar_normal_scale(davar_normal_t *normal);

/* Inverse of the rows and columns of `terms`. False: the cluster sizes cannot tell these terms apart. */
bool davar_invert(const davar_normal_t *normal, unsigned terms, davar_inverse_t *inverse);

/* a of row i of the inverse. */
double davar_solution(const davar_normal_t *normal, const davar_inverse_t *inverse, int i);

/* Its variance; scatter: X' W C W X, C the covariance of the Allan variances, scaled as the normal equations. INFINITY: terms so
 * alike that an approximate C has nothing to say about them. */
double davar_solution_variance(const davar_normal_t *normal, const davar_inverse_t *inverse,
                               const davar_matrix_t *scatter, int i);

/* Least squares over `terms`, without those that come out negative. Returns the terms that are left, with a[k] of each and
 * 0 for the others; 0: the cluster sizes cannot tell them apart, and a[] is worth nothing. */
unsigned davar_solve_non_negative(const davar_normal_t *normal, unsigned terms, double a[]);

#endif
