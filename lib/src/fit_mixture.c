/* davar - weighted least squares for a mix of noise terms, DESIGN (5.6) to (5.9). Weights come from the model, not from the
 * data: weights from the data favour estimates that happen to be low. The cluster sizes are correlated; the weights ignore
 * that (a full inverse is ill-conditioned for dense ones) and the variance of the outcome does not. */
#include "fit_mixture.h"

#include "noise.h"

#include <math.h>

#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE (1U << (unsigned)DAVAR_ANGLE_RANDOM_WALK)

/* Reweighting settles to a small fraction of a standard error in this many rounds. */
#define ROUNDS 6

/* Below this pivot two terms have the same shape as far as these cluster sizes can tell. */
#define PIVOT_MIN 1e-10

typedef struct {
    double at[DAVAR_COEFFICIENT_COUNT][DAVAR_COEFFICIENT_COUNT];
} matrix_t;

typedef struct {
    matrix_t matrix;                       /* X' W X, scaled to a unit diagonal */
    double right[DAVAR_COEFFICIENT_COUNT]; /* X' W avar, scaled */
    double scale[DAVAR_COEFFICIENT_COUNT]; /* what made the diagonal 1: a = scale * solution */
} normal_t;

static bool has(unsigned terms, int term)
{
    return ((terms >> (unsigned)term) & 1U) != 0U;
}

static void shapes(double m, double x[])
{
    const double inverse = 1.0 / m;
    x[DAVAR_QUANTIZATION] = inverse * inverse;
    x[DAVAR_ANGLE_RANDOM_WALK] = inverse;
    x[DAVAR_BIAS_INSTABILITY] = 1.0;
    x[DAVAR_RATE_RANDOM_WALK] = m;
    x[DAVAR_RATE_RAMP] = m * m;
}

/* Terms outside the model hold a fit of their own in a[]; they are no part of it. */
static double avar_of(const davar_mixture_t *model, double m)
{
    double x[DAVAR_COEFFICIENT_COUNT];
    shapes(m, x);
    double sum = 0.0;
    for (int k = 0; k < TERMS; k++) {
        sum += has(model->terms, k) ? model->a[k] * x[k] : 0.0;
    }
    return sum;
}

double davar_mixture_room(const davar_mixture_t *model, int term)
{
    const int end = ((term == (int)DAVAR_QUANTIZATION) || (term == (int)DAVAR_ANGLE_RANDOM_WALK)) ? 0 : model->count - 1;
    const double m = (double)model->data->tau[end].m;
    double x[DAVAR_COEFFICIENT_COUNT];
    shapes(m, x);
    return avar_of(model, m) / x[term];
}

double davar_mixture_edf(const davar_mixture_t *model, const davar_adev_t *tau)
{
    const double m = (double)tau->m;
    const double all = (double)model->data->window_samples - 2.0 * m + 1.0;
    double x[DAVAR_COEFFICIENT_COUNT];
    shapes(m, x);
    double inverse = 0.0;
    for (int k = 0; k < TERMS; k++) {
        if (has(model->terms, k)) {
            inverse += model->a[k] * x[k] / davar_noise_edf((davar_coefficient_kind_t)k, m, all);
        }
    }
    const double edf = avar_of(model, m) / inverse * ((double)tau->differences / all);
    return (edf > 1.0) ? edf : 1.0;
}

static void equilibrate(normal_t *normal)
{
    for (int k = 0; k < TERMS; k++) {
        normal->scale[k] = 1.0 / sqrt(normal->matrix.at[k][k]);
    }
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            normal->matrix.at[k][l] *= normal->scale[k] * normal->scale[l];
        }
        normal->right[k] *= normal->scale[k];
    }
}

/* trust: 1 takes the weights from the model; less mixes in the data, for a model that may still be far off. */
static void normal_equations(const davar_mixture_t *model, double trust, normal_t *normal)
{
    *normal = (normal_t){0};
    for (int t = 0; t < model->count; t++) {
        const davar_adev_t *tau = &model->data->tau[t];
        const double avar = tau->adev * tau->adev;
        double x[DAVAR_COEFFICIENT_COUNT];
        shapes((double)tau->m, x);
        const double expected = trust * avar_of(model, (double)tau->m) + (1.0 - trust) * avar;
        const double weight = (double)model->weight[t] / (expected * expected);
        for (int k = 0; k < TERMS; k++) {
            for (int l = 0; l < TERMS; l++) {
                normal->matrix.at[k][l] += weight * x[k] * x[l];
            }
            normal->right[k] += weight * x[k] * avar;
        }
    }
    equilibrate(normal);
}

static void eliminate(matrix_t *a, int pivot)
{
    const double inverse = 1.0 / a->at[pivot][pivot];
    a->at[pivot][pivot] = 1.0;
    for (int l = 0; l < TERMS; l++) {
        a->at[pivot][l] *= inverse;
    }
    for (int k = 0; k < TERMS; k++) {
        if (k != pivot) {
            const double multiple = a->at[k][pivot];
            a->at[k][pivot] = 0.0;
            for (int l = 0; l < TERMS; l++) {
                a->at[k][l] -= multiple * a->at[pivot][l];
            }
        }
    }
}

static void select_terms(const matrix_t *all, unsigned terms, matrix_t *some)
{
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            some->at[k][l] = (has(terms, k) && has(terms, l)) ? all->at[k][l] : 0.0;
        }
    }
}

/* Inverse over the rows and columns of `terms`, zero elsewhere (Gauss-Jordan; a positive definite matrix needs no
 * exchange of rows). False: the cluster sizes cannot tell these terms apart. */
static bool invert(const matrix_t *matrix, unsigned terms, matrix_t *inverse)
{
    select_terms(matrix, terms, inverse);
    for (int k = 0; k < TERMS; k++) {
        if (has(terms, k)) {
            if (!(inverse->at[k][k] > PIVOT_MIN)) {
                return false;
            }
            eliminate(inverse, k);
        }
    }
    return true;
}

static double solution(const normal_t *normal, const matrix_t *inverse, int term)
{
    double sum = 0.0;
    for (int l = 0; l < TERMS; l++) {
        sum += inverse->at[term][l] * normal->right[l];
    }
    return sum;
}

/* The most negative term of the solution, which is stored; -1: none. */
static int solve(davar_mixture_t *model, const normal_t *normal, const matrix_t *inverse)
{
    int worst = -1;
    double lowest = 0.0;
    for (int k = 0; k < TERMS; k++) {
        const double value = solution(normal, inverse, k);
        model->a[k] = value * normal->scale[k];
        worst = (value < lowest) ? k : worst;
        lowest = (value < lowest) ? value : lowest;
    }
    return worst;
}

/* Least squares over `terms`, without those that come out negative. One term alone is positive: this ends. */
static bool solve_non_negative(davar_mixture_t *model, const normal_t *normal, unsigned terms)
{
    int worst;
    do {
        matrix_t inverse;
        if (!invert(&normal->matrix, terms, &inverse)) {
            return false;
        }
        worst = solve(model, normal, &inverse);
        model->terms = terms;
        terms &= (worst < 0) ? terms : ~(1U << (unsigned)worst);
    } while (worst >= 0);
    return true;
}

/* Iteratively reweighted least squares from wherever *model stands. */
static bool converge(davar_mixture_t *model, unsigned terms)
{
    normal_t normal;
    for (int round = 0; round < ROUNDS; round++) {
        normal_equations(model, (round == 0) ? 0.5 : 1.0, &normal);
        if (!solve_non_negative(model, &normal, terms)) {
            return false;
        }
    }
    return true;
}

/* Covariance of two Allan variances of the model over the product of their standard deviations. Each term gives its own
 * correlation, weighted with its share of both, a power of the geometric mean of the two cluster sizes (5.8). */
static double correlation(const davar_mixture_t *model, double m_short, double m_long, double scale)
{
    double x[DAVAR_COEFFICIENT_COUNT];
    shapes(sqrt(m_short * m_long), x);
    double sum = 0.0;
    for (int k = 0; k < TERMS; k++) {
        if (has(model->terms, k)) {
            sum += model->a[k] * x[k] * davar_noise_correlation((davar_coefficient_kind_t)k, m_short, m_long);
        }
    }
    return sum * scale;
}

/* Adds weight * weight * covariance of two entries to X' W C W X. */
static void add_pair(matrix_t *h, double m_short, double m_long, double covariance)
{
    double x[DAVAR_COEFFICIENT_COUNT];
    double y[DAVAR_COEFFICIENT_COUNT];
    shapes(m_short, x);
    shapes(m_long, y);
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            h->at[k][l] += covariance * (x[k] * y[l] + ((m_short < m_long) ? x[l] * y[k] : 0.0));
        }
    }
}

/* X' W C W X, scaled as the normal equations: the middle of the sandwich. */
static void scatter(const davar_mixture_t *model, const normal_t *normal, matrix_t *h)
{
    double root[DAVAR_TAUS_MAX]; /* W * standard deviation / sqrt(avar) */
    *h = (matrix_t){0};
    for (int j = 0; j < model->count; j++) {
        const davar_adev_t *tau = &model->data->tau[j];
        const double avar = avar_of(model, (double)tau->m);
        root[j] = (double)model->weight[j] / avar * sqrt(2.0 / (davar_mixture_edf(model, tau) * avar));
        for (int i = 0; i <= j; i++) {
            const double m_short = (double)model->data->tau[i].m;
            const double m_long = (double)tau->m;
            add_pair(h, m_short, m_long, correlation(model, m_short, m_long, root[i] * root[j]));
        }
    }
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            h->at[k][l] *= normal->scale[k] * normal->scale[l];
        }
    }
}

static double sandwich(const matrix_t *inverse, const matrix_t *h, int term)
{
    double sum = 0.0;
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            sum += inverse->at[term][k] * h->at[k][l] * inverse->at[term][l];
        }
    }
    return sum;
}

static double variance_of(const normal_t *normal, const matrix_t *inverse, const matrix_t *h, int term)
{
    return sandwich(inverse, h, term) * normal->scale[term] * normal->scale[term];
}

/* Fits one term together with the model; the model's noise gives weights and scatter, so for an absent term this is a
 * test of the model without it (a score test). False: the cluster sizes cannot tell it apart. */
static bool judge(davar_mixture_t *model, const normal_t *normal, const matrix_t *h, int term, matrix_t *inverse)
{
    if (!invert(&normal->matrix, model->terms | (1U << (unsigned)term), inverse)) {
        model->a[term] = 0.0;
        model->variance[term] = (double)INFINITY;
        return false;
    }
    model->a[term] = has(model->terms, term) ? model->a[term] : solution(normal, inverse, term) * normal->scale[term];
    model->variance[term] = variance_of(normal, inverse, h, term);
    return true;
}

static void judge_absent(davar_mixture_t *model)
{
    normal_t normal;
    matrix_t h;
    matrix_t inverse;
    normal_equations(model, 1.0, &normal);
    scatter(model, &normal, &h);
    for (int k = 0; k < TERMS; k++) {
        if (!has(model->terms, k)) {
            (void)judge(model, &normal, &h, k, &inverse);
        }
    }
}

static bool significant(const davar_mixture_t *model, int term)
{
    return model->a[term] > DAVAR_FIT_THRESHOLD * sqrt(model->variance[term]);
}

/* Twice the log-likelihood that the data lose against a perfect model, r - 1 - ln r without the logarithm. */
static double misfit(const davar_mixture_t *model)
{
    double sum = 0.0;
    for (int t = 0; t < model->count; t++) {
        const davar_adev_t *tau = &model->data->tau[t];
        const double ratio = tau->adev * tau->adev / avar_of(model, (double)tau->m);
        sum += davar_mixture_edf(model, tau) * 1.5 * (ratio - 1.0) * (ratio - 1.0) / (1.0 + 2.0 * ratio);
    }
    return sum;
}

/* Adds the significant term that explains most. False: none. */
static bool add_term(davar_mixture_t *model)
{
    davar_mixture_t best = *model;
    double least = (double)INFINITY;
    judge_absent(model);
    for (int k = 0; k < TERMS; k++) {
        davar_mixture_t trial = *model;
        if (!has(model->terms, k) && significant(model, k) && converge(&trial, model->terms | (1U << (unsigned)k))) {
            const double left = misfit(&trial);
            if (left < least) {
                least = left;
                best = trial;
            }
        }
    }
    *model = best;
    return least < (double)INFINITY;
}

/* Takes out the terms that are not significant beside the others. */
static void prune(davar_mixture_t *model)
{
    for (int k = 0; k < TERMS; k++) {
        const unsigned others = model->terms & ~(1U << (unsigned)k);
        davar_mixture_t trial = *model;
        if (has(model->terms, k) && (others != 0U) && converge(&trial, others)) {
            judge_absent(&trial);
            if (!significant(&trial, k)) {
                *model = trial;
            }
        }
    }
}

static unsigned term_count(unsigned terms)
{
    unsigned count = 0;
    for (int k = 0; k < TERMS; k++) {
        count += (terms >> (unsigned)k) & 1U;
    }
    return count;
}

/* A model that does not fit (a filtered sensor, a sinusoid) must not boast: its variances grow by the misfit. */
static double inflation(const davar_mixture_t *model)
{
    const double freedom = (double)model->count - (double)term_count(model->terms);
    const double left = misfit(model);
    const bool real = left > freedom + DAVAR_FIT_MISFIT * model->misfit_spread;
    return real ? left / ((freedom > 1.0) ? freedom : 1.0) : 1.0;
}

static double lower_limit(double a, double variance)
{
    const double s = sqrt(0.5 * variance) / a;
    return a * davar_chi_square_low((s < 1.0) ? s : 1.0);
}

static void lower(double *least, double value)
{
    *least = (value < *least) ? value : *least;
}

/* A term that may be there but is not resolved takes from the others: their intervals reach down to the fit with it. */
static void doubt(davar_mixture_t *model, const normal_t *normal, const matrix_t *inverse, const matrix_t *h, double grow)
{
    for (int k = 0; k < TERMS; k++) {
        if (has(model->terms, k)) {
            const double a = solution(normal, inverse, k) * normal->scale[k];
            const double variance = variance_of(normal, inverse, h, k) * grow;
            const bool nothing = sqrt(0.5 * variance) >= DAVAR_FIT_NOTHING * a;
            lower(&model->least[k], nothing ? 0.0 : lower_limit(a, variance));
        }
    }
}

/* Variances, lower limits, and the fits of the absent terms beside the model. */
static void conclude(davar_mixture_t *model)
{
    const double grow = inflation(model);
    normal_t normal;
    matrix_t h;
    normal_equations(model, 1.0, &normal);
    scatter(model, &normal, &h);
    for (int k = 0; k < TERMS; k++) {
        model->least[k] = (double)INFINITY;
    }
    for (int k = 0; k < TERMS; k++) {
        matrix_t inverse;
        const bool resolved = judge(model, &normal, &h, k, &inverse);
        model->variance[k] *= grow;
        if (has(model->terms, k)) {
            lower(&model->least[k], lower_limit(model->a[k], model->variance[k]));
        } else if (resolved && (model->a[k] > DAVAR_FIT_DOUBT * sqrt(model->variance[k]))) {
            doubt(model, &normal, &inverse, &h, grow);
        }
    }
}

static double mean_white(const davar_mixture_t *model)
{
    double sum = 0.0;
    for (int t = 0; t < model->count; t++) {
        const davar_adev_t *tau = &model->data->tau[t];
        sum += tau->adev * tau->adev * (double)tau->m;
    }
    return sum / (double)model->count;
}

void davar_mixture_fit(davar_mixture_t *model)
{
    model->terms = WHITE;
    model->a[DAVAR_ANGLE_RANDOM_WALK] = mean_white(model);
    (void)converge(model, WHITE);
    for (int k = 1; (k < TERMS) && add_term(model); k++) {
        prune(model);
    }
    conclude(model);
}
