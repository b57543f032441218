/* davar - weighted least squares, DESIGN (5.6): normal equations, Gauss-Jordan, the sandwich. */
#include "fit/least_squares.h"

#include "fit/noise.h"
#include "number/real.h"

/* Below this pivot two terms have the same shape as far as these cluster sizes can tell. */
#define PIVOT_MIN 1e-10

DAVAR_RARE void davar_normal_add(davar_normal_t *normal, double m, double avar, double weight_per_m2)
{
    double power = weight_per_m2 / (m * m);
    double product = weight_per_m2 * avar;
    normal->count++;
    for (int k = 0; k < TERMS; k++) {
        normal->right[k] += product;
        product *= m;
    }
    for (int p = 0; p < 2 * TERMS - 1; p++) {
        normal->moment[p] += power;
        power *= m;
    }
}

DAVAR_RARE void davar_normal_scale(davar_normal_t *normal)
{
    for (int k = 0; k < TERMS; k++) {
        normal->scale[k] = 1.0 / davar_root(normal->moment[k + k]);
        normal->right[k] *= normal->scale[k];
    }
}

/* Rows and columns of X' W X for the terms in `terms`, in ascending order. */
static void select_terms(const davar_normal_t *normal, unsigned terms, davar_inverse_t *some)
{
    some->size = 0;
    for (int k = 0; k < TERMS; k++) {
        if (davar_has_term(terms, k)) {
            some->term[some->size++] = k;
        }
    }
    for (int i = 0; i < some->size; i++) {
        const int k = some->term[i];
        for (int j = 0; j <= i; j++) {
            const int l = some->term[j];
            some->at[i][j] = normal->moment[k + l] * normal->scale[k] * normal->scale[l];
            some->at[j][i] = some->at[i][j];
        }
    }
}

static void eliminate(davar_inverse_t *a, int pivot)
{
    const double inverse = 1.0 / a->at[pivot][pivot];
    a->at[pivot][pivot] = 1.0;
    for (int j = 0; j < a->size; j++) {
        a->at[pivot][j] *= inverse;
    }
    for (int i = 0; i < a->size; i++) {
        if (i != pivot) {
            const double multiple = a->at[i][pivot];
            a->at[i][pivot] = 0.0;
            for (int j = 0; j < a->size; j++) {
                a->at[i][j] -= multiple * a->at[pivot][j];
            }
        }
    }
}

/* Gauss-Jordan; a positive definite matrix needs no exchange of rows. */
DAVAR_RARE bool davar_invert(const davar_normal_t *normal, unsigned terms, davar_inverse_t *inverse)
{
    select_terms(normal, terms, inverse);
    if (inverse->size > normal->count) {
        return false;
    }
    for (int i = 0; i < inverse->size; i++) {
        if (!(inverse->at[i][i] > PIVOT_MIN)) {
            return false;
        }
        eliminate(inverse, i);
    }
    return true;
}

DAVAR_RARE double davar_solution(const davar_normal_t *normal, const davar_inverse_t *inverse, int i)
{
    double sum = 0.0;
    for (int j = 0; j < inverse->size; j++) {
        sum += inverse->at[i][j] * normal->right[inverse->term[j]];
    }
    return sum * normal->scale[inverse->term[i]];
}

DAVAR_RARE double davar_solution_variance(const davar_normal_t *normal, const davar_inverse_t *inverse,
                                          const davar_matrix_t *scatter, int i)
{
    const double scale = normal->scale[inverse->term[i]];
    double sum = 0.0;
    for (int j = 0; j < inverse->size; j++) {
        double row = 0.0;
        for (int l = 0; l < inverse->size; l++) {
            row += scatter->at[inverse->term[j]][inverse->term[l]] * inverse->at[i][l];
        }
        sum += inverse->at[i][j] * row;
    }
    return (sum > 0.0) ? (sum * (scale * scale)) : (double)INFINITY;
}

/* Stores the solution; returns its most negative term, -1 if there is none. */
static int solve(const davar_normal_t *normal, const davar_inverse_t *inverse, double a[])
{
    int worst = -1;
    double lowest = 0.0;
    for (int k = 0; k < TERMS; k++) {
        a[k] = 0.0;
    }
    for (int i = 0; i < inverse->size; i++) {
        const int k = inverse->term[i];
        a[k] = davar_solution(normal, inverse, i);
        if (a[k] < lowest * normal->scale[k]) {
            worst = k;
            lowest = a[k] / normal->scale[k];
        }
    }
    return worst;
}

/* One term alone is positive: this ends. */
DAVAR_RARE unsigned davar_solve_non_negative(const davar_normal_t *normal, unsigned terms, double a[])
{
    davar_inverse_t inverse;
    while (davar_invert(normal, terms, &inverse)) {
        const int worst = solve(normal, &inverse, a);
        if (worst < 0) {
            return terms;
        }
        terms &= ~davar_term_bit(worst);
    }
    return 0U;
}
