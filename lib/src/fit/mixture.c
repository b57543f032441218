/* davar - a mix of noise terms, its variances and its selection, DESIGN (5.6) to (5.10). The
 * weights of least squares come from the model, because weights from the data favour estimates that
 * happen to be low. The cluster sizes are correlated. The variances take the whole correlation into
 * account, the weights only the crowding of sizes: the inverse of the full covariance is
 * ill-conditioned. */
#include "fit/mixture.h"

#include "fit/plan.h"
#include "fit/white.h"
#include "number/real.h"

/* Below this pivot, two terms have the same shape at these cluster sizes. */
#define PIVOT_MIN 1e-10

/* A plan whose shortest size has at least this gain declares no filter. */
#define PASSES_ALL 0.99F

/* Degrees of freedom whose two-sided limit is the one-sided one: (1.96 / 1.645)^2 times as many. */
#define ONE_SIDED 1.42
#define GAUSSIAN_MARGIN 1.645 /* standard errors; that of chi-square is wider */

/* Rounds of reweighting: enough to compare models, and to converge to a small fraction of a
 * standard error. */
#define ROUNDS_TRIAL 2
#define ROUNDS_FINAL 2

/* Terms of a model: bit k for term k. */
static unsigned term_bit(int term)
{
    return 1U << (unsigned)term;
}

#define ALL_TERMS ((1U << (unsigned)TERMS) - 1U)

static bool has_term(unsigned terms, int term)
{
    return (terms & term_bit(term)) != 0U;
}

typedef struct {
    double at[TERMS][TERMS];
} matrix_t;

/* The normal equations of all five terms. */
typedef struct {
    int count;           /* of Allan variances, and the most terms that they resolve */
    matrix_t moment;     /* X' W X */
    double right[TERMS]; /* X' W avar, scaled */
    double scale[TERMS]; /* makes the diagonal of X' W X 1: a = scale * solution */
} normal_t;

/* Inverse over some of the terms: row i belongs to term[i], in ascending order. */
typedef struct {
    int size;
    int term[TERMS];
    double at[TERMS][TERMS];
} inverse_t;

static double square(double x)
{
    return x * x;
}

double davar_mixture_white(const davar_mixture_t *model, int t)
{
    const davar_adev_t *const tau = &model->data->tau[t];
    const double gain = (double)model->plan->gain[t];
    return davar_hops(tau) ? gain * (double)tau->power : gain;
}

static double rounding_at(const davar_mixture_t *model, int t)
{
    return model->rounding / (double)model->plan->m[t];
}

/* The Allan variance of the model at size t of the plan, and x[k], those of unit amplitudes. */
DAVAR_APART static double avar_of(const davar_mixture_t *model, int t, double x[])
{
    const davar_plan_t *const plan = model->plan;
    const double m = (double)plan->m[t];
    const double inverse = 1.0 / m;
    double sum = rounding_at(model, t);
    x[DAVAR_QUANTIZATION] = inverse * inverse;
    x[DAVAR_ANGLE_RANDOM_WALK] = inverse * davar_mixture_white(model, t);
    x[DAVAR_BIAS_INSTABILITY] = square((double)plan->flicker[t]);
    x[DAVAR_RATE_RANDOM_WALK] = m * square((double)plan->walk[t]);
    x[DAVAR_RATE_RAMP] = m * m;
    for (int k = 0; k < TERMS; k++) {
        if (has_term(model->terms, k)) { /* the others are 0 */
            sum += model->a[k] * x[k];
        }
    }
    return sum;
}

bool davar_mixture_has(const davar_mixture_t *model, int t)
{
    return model->data->tau[t].differences > 0U;
}

static bool is_of_cascade(const davar_mixture_t *model)
{
    return davar_hops(&model->data->tau[model->first]);
}

/* Weight of size t in least squares: it grows with what the size looks back over (5.18). */
static double weight_of(const davar_mixture_t *model, int t)
{
    const davar_adev_t *const tau = &model->data->tau[t];
    const double weight = (double)model->plan->weight[t];
    return davar_hops(tau) ? (weight * davar_hop_span(tau)) : weight;
}

/* Degrees of freedom of size t, of a whole window, if there were only this term. */
static double edf_of_term(const davar_mixture_t *model, int t, int term)
{
    const davar_adev_t *const tau = &model->data->tau[t];
    const davar_coefficient_kind_t kind = (davar_coefficient_kind_t)term;
    const double m = (double)tau->m;
    const double white = (double)model->plan->freedom[t];
    double edf;
    if (davar_hops(tau)) {
        const double filtered = (term == WHITE) ? white / davar_noise_white_weight(m) : 1.0;
        const double even = (term == WHITE) ? DAVAR_EVEN / (double)tau->uneven : 1.0;
        edf = davar_hop_edf(kind, tau->differences, tau->hops) * filtered * even;
    } else {
        const double all = (double)model->data->window_samples - 2.0 * m + 1.0;
        edf = (term == WHITE) ? white * (all + 0.5 * m) : davar_noise_edf(kind, m, all);
    }
    return (edf > 1.0) ? edf : 1.0;
}

/* Degrees of freedom of an Allan variance of this mix without heavy tails. */
static double edf_without_tails(const davar_mixture_t *model, int t)
{
    double x[TERMS];
    const double avar = avar_of(model, t, x);
    double inverse = rounding_at(model, t) / edf_of_term(model, t, WHITE);
    for (int k = 0; k < TERMS; k++) {
        if (has_term(model->terms, k)) {
            inverse += model->a[k] * x[k] / edf_of_term(model, t, k);
        }
    }
    const double edf = avar / inverse * davar_fit_kept(model->data, &model->data->tau[t]);
    return (edf > 1.0) ? edf : 1.0;
}

/* Half of the relative variance that heavy tails add to white noise at size t; 0 for a cascade,
 * whose kurtosis is unknown (5.19). */
static double tails_of_size(const davar_mixture_t *model, int t)
{
    const davar_adev_t *const tau = &model->data->tau[t];
    const double effective = (double)model->data->window_samples + 1.0 - 1.5 * (double)tau->m;
    return davar_hops(tau)
               ? 0.0
               : ((double)model->plan->half_kappa / (effective * davar_fit_kept(model->data, tau)));
}

DAVAR_RARE double davar_mixture_edf(const davar_mixture_t *model, int t)
{
    double x[TERMS];
    const double avar = avar_of(model, t, x);
    const double share = model->a[WHITE] * x[WHITE] / avar;
    const double edf = edf_without_tails(model, t);
    const double widened = edf / (1.0 + edf * tails_of_size(model, t) * square(share));
    return (widened > 1.0) ? widened : 1.0;
}

DAVAR_RARE double davar_mixture_most(const davar_mixture_t *model, int term)
{
    const int last = model->end - 1;
    const bool passes = (term != WHITE) || is_of_cascade(model);
    const int short_one = passes ? model->first : (int)model->plan->white.passed;
    const int strongest = (term <= WHITE) ? short_one : last;
    double x[TERMS];
    double low;
    double high;
    const double avar = avar_of(model, strongest, x);
    const double room = avar / x[term];
    const double a = (model->tried[term] > 0.0) ? model->tried[term] : 0.0;
    const double edf = 2.0 * square(room) / model->variance[term];
    davar_chi_square_interval(edf * ONE_SIDED, &low, &high);
    /* a room of a million standard errors: `high` has too few bits beyond 1 */
    const double gaussian = GAUSSIAN_MARGIN * davar_root(model->variance[term]);
    const double margin = room * (high - 1.0);
    const double most = a * high + ((margin > gaussian) ? margin : gaussian);
    return (edf > 0.0) ? most : (double)INFINITY;
}

bool davar_mixture_shows_white(const davar_mixture_t *model)
{
    for (int t = model->first; t < model->end; t++) {
        double x[TERMS];
        const double avar = avar_of(model, t, x);
        if (!(model->plan->gain[t] < DAVAR_FIT_PASSED) &&
            (2.0 * model->a[WHITE] * x[WHITE] >= avar - rounding_at(model, t))) {
            return true;
        }
    }
    return false;
}

bool davar_mixture_is_filtered(const davar_mixture_t *model)
{
    const davar_plan_t *const plan = model->plan;
    const bool cascade = is_of_cascade(model); /* no filter is as slow */
    const bool fits = cascade || !(model->grow > 1.0);
    const bool quantized = has_term(model->terms, DAVAR_QUANTIZATION);
    const double lack = -model->tried[DAVAR_QUANTIZATION];
    const double sigma = davar_root(model->variance[DAVAR_QUANTIZATION]);
    if (!quantized && (lack > DAVAR_FIT_THRESHOLD * sigma)) {
        return true;
    }
    if (plan->white
            .declared) { /* a filter passes no quantization, and nothing that no term gives */
        return (plan->gain[0] < PASSES_ALL) && (quantized || !fits);
    }
    return !cascade && (!fits || !davar_mixture_shows_white(model));
}

/* --- least squares (5.6) --- */

/* For some terms only; the rest of *normal is 0. trust: 1 takes the weights from the model. A
 * smaller value mixes in the data, for a model that may still be far off. */
static void normal_equations(const davar_mixture_t *model, unsigned terms, double trust,
                             normal_t *normal)
{
    *normal = (normal_t){0};
    for (int t = model->first; t < model->end; t++) {
        double x[TERMS];
        if (!davar_mixture_has(model, t)) {
            continue;
        }
        normal->count++;
        const double avar = square(model->data->tau[t].adev);
        const double without_rounding = avar - rounding_at(model, t);
        const double expected = trust * avar_of(model, t, x) + (1.0 - trust) * avar;
        const double weight = weight_of(model, t) / square(expected);
        for (int k = 0; k < TERMS; k++) {
            if (!has_term(terms, k)) {
                continue;
            }
            const double weighted = weight * x[k];
            normal->right[k] += weighted * without_rounding;
            for (int l = 0; l <= k; l++) {
                normal->moment.at[k][l] += weighted * x[l];
            }
        }
    }
    for (int k = 0; k < TERMS; k++) {
        if (has_term(terms, k)) {
            normal->scale[k] = 1.0 / davar_root(normal->moment.at[k][k]);
            normal->right[k] *= normal->scale[k];
        }
    }
}

/* Rows and columns of X' W X for the terms in `terms`, in ascending order. */
static void select_terms(const normal_t *normal, unsigned terms, inverse_t *some)
{
    some->size = 0;
    for (int k = 0; k < TERMS; k++) {
        if (has_term(terms, k)) {
            some->term[some->size++] = k;
        }
    }
    for (int i = 0; i < some->size; i++) {
        const int k = some->term[i];
        for (int j = 0; j <= i; j++) {
            const int l = some->term[j];
            some->at[i][j] = normal->moment.at[k][l] * normal->scale[k] * normal->scale[l];
            some->at[j][i] = some->at[i][j];
        }
    }
}

static void eliminate(inverse_t *a, int pivot)
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

/* Inverse of the rows and columns of `terms`, by Gauss-Jordan. The matrix is positive definite, so
 * no rows are exchanged. False: these cluster sizes cannot separate the terms. */
DAVAR_RARE static bool invert(const normal_t *normal, unsigned terms, inverse_t *inverse)
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

/* a of row i of the inverse. */
DAVAR_RARE static double solution(const normal_t *normal, const inverse_t *inverse, int i)
{
    double sum = 0.0;
    for (int j = 0; j < inverse->size; j++) {
        sum += inverse->at[i][j] * normal->right[inverse->term[j]];
    }
    return sum * normal->scale[inverse->term[i]];
}

/* Variance of that. `scatter` is X' W C W X, scaled as the normal equations; C is the covariance of
 * the Allan variances. INFINITY: the terms are too similar for the approximate C. */
DAVAR_RARE static double solution_variance(const normal_t *normal, const inverse_t *inverse,
                                           const matrix_t *scatter, int i)
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
static int solve(const normal_t *normal, const inverse_t *inverse, double a[])
{
    int worst = -1;
    double lowest = 0.0;
    for (int k = 0; k < TERMS; k++) {
        a[k] = 0.0;
    }
    for (int i = 0; i < inverse->size; i++) {
        const int k = inverse->term[i];
        a[k] = solution(normal, inverse, i);
        if (a[k] < lowest * normal->scale[k]) {
            worst = k;
            lowest = a[k] / normal->scale[k];
        }
    }
    return worst;
}

/* Least squares over `terms`, without those that become negative. Returns the remaining terms, with
 * a[k] of each and 0 for the others. 0: the cluster sizes cannot separate them, and a[] is not
 * valid. One term alone is positive, so the loop ends. */
DAVAR_RARE static unsigned solve_non_negative(const normal_t *normal, unsigned terms, double a[])
{
    inverse_t inverse;
    while (invert(normal, terms, &inverse)) {
        const int worst = solve(normal, &inverse, a);
        if (worst < 0) {
            return terms;
        }
        terms &= ~term_bit(worst);
    }
    return 0U;
}

/* Iteratively reweighted least squares. trust: see normal_equations, for the first round. */
static bool converge(davar_mixture_t *model, unsigned terms, double trust, int rounds)
{
    normal_t normal;
    for (int round = 0; round < rounds; round++) {
        normal_equations(model, terms, (round == 0) ? trust : 1.0, &normal);
        const unsigned left = solve_non_negative(&normal, terms, model->a);
        if (left == 0U) {
            return false;
        }
        model->terms = left;
    }
    return true;
}

/* --- variances --- */

/* Correlation of the Allan variances of white noise at two sizes (5.3) (5.16). */
static double white_correlation(const davar_plan_t *plan, int t, int u)
{
    return (double)plan->covariance[plan_pair(t, u)] /
           davar_root((double)plan->covariance[plan_pair(t, t)] *
                      (double)plan->covariance[plan_pair(u, u)]);
}

/* Correlation of two estimates that look back over different spans, over that of equal spans: the
 * newer part of the longer span is the shorter one (5.18). */
static double shared_by(const davar_mixture_t *model, int t, int u)
{
    const davar_adev_t *const tau = model->data->tau;
    if (!davar_hops(&tau[u])) {
        return 1.0;
    }
    const double ratio = davar_hop_span(&tau[t]) / davar_hop_span(&tau[u]);
    return davar_root((ratio < 1.0) ? ratio : (1.0 / ratio));
}

/* Covariance of two Allan variances of the model, t < u, over the product of sqrt(variance / avar).
 * Each term has its own correlation, weighted with the geometric mean of its parts (5.8). */
static double covariance(const davar_mixture_t *model, int t, int u)
{
    const davar_plan_t *const plan = model->plan;
    const double m_t = (double)plan->m[t];
    const double m_u = (double)plan->m[u];
    const double mean = davar_root(m_t * m_u);
    const double *const a = model->a;
    const double white =
        (a[WHITE] * davar_root(davar_mixture_white(model, t) * davar_mixture_white(model, u)) +
         model->rounding) /
        mean;
    const double part[] = {
        a[DAVAR_QUANTIZATION] / square(mean), 0.0,
        a[DAVAR_BIAS_INSTABILITY] * (double)plan->flicker[t] * (double)plan->flicker[u],
        a[DAVAR_RATE_RANDOM_WALK] * (double)plan->walk[t] * (double)plan->walk[u] * mean,
        a[DAVAR_RATE_RAMP] * square(mean)};
    double sum = white * white_correlation(plan, t, u);
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && has_term(model->terms, k)) {
            sum += part[k] * davar_noise_correlation((davar_coefficient_kind_t)k, m_t, m_u);
        }
    }
    return sum * shared_by(model, t, u);
}

/* Twice the log-likelihood that an estimate with one degree of freedom loses: r - 1 - ln r, without
 * a logarithm (5.9). */
DAVAR_APART static double loss(double ratio)
{
    return 1.5 * square(ratio - 1.0) / (1.0 + 2.0 * ratio);
}

/* Row u of C W X up to the diagonal, of which only one half counts here; factor: W * sqrt(variance
 * / avar). */
static void covariance_row(const davar_mixture_t *model, int u, const double factor[], double row[])
{
    for (int t = model->first; t <= u; t++) {
        if (!davar_mixture_has(model, t)) {
            continue;
        }
        double x[TERMS];
        const double avar = avar_of(model, t, x);
        const double share = (t < u) ? covariance(model, t, u) : 0.5 * avar;
        for (int k = 0; k < TERMS; k++) {
            row[k] += share * factor[t] * x[k];
        }
    }
}

/* X' W C W X (5.6), scaled as the normal equations: each row of C W X times a row of X, and its
 * transpose, and the uncertainty of the cutoff, which moves all sizes together (5.16). Returns the
 * misfit, twice the log-likelihood that the data lose against a perfect model. */
static double scatter(const davar_mixture_t *model, const normal_t *normal, matrix_t *h)
{
    const davar_plan_t *const plan = model->plan;
    double factor[DAVAR_TAUS_MAX];
    double moved[TERMS] = {0};
    double misfit = 0.0;
    *h = (matrix_t){0};
    for (int u = model->first; u < model->end; u++) {
        if (!davar_mixture_has(model, u)) {
            continue;
        }
        double row[TERMS] = {0};
        double x[TERMS];
        const double avar = avar_of(model, u, x);
        const double weight = weight_of(model, u) / square(avar);
        const double offset = model->a[WHITE] * x[WHITE] * (double)plan->offset[u];
        const double edf = edf_without_tails(model, u);
        const double inverse = 1.0 / edf + 0.5 * square(offset / avar);
        misfit += loss(square(model->data->tau[u].adev) / avar) / inverse;
        factor[u] = weight * davar_root(2.0 * avar / edf);
        covariance_row(model, u, factor, row);
        for (int k = 0; k < TERMS; k++) {
            row[k] *= factor[u] * normal->scale[k];
            x[k] *= normal->scale[k];
            moved[k] += weight * offset * x[k];
        }
        for (int k = 0; k < TERMS; k++) {
            for (int l = 0; l < TERMS; l++) {
                h->at[k][l] += row[k] * x[l] + x[k] * row[l];
            }
        }
    }
    for (int k = 0; k < TERMS; k++) {
        for (int l = 0; l < TERMS; l++) {
            h->at[k][l] += moved[k] * moved[l];
        }
    }
    return misfit;
}

static int term_count(unsigned terms)
{
    int count = 0;
    for (int k = 0; k < TERMS; k++) {
        count += has_term(terms, k) ? 1 : 0;
    }
    return count;
}

/* Standard deviation of the misfit: of a window from the plan, of a cascade from its
 * sizes (5.9). */
static double spread_of_misfit(const davar_mixture_t *model)
{
    if (!is_of_cascade(model)) {
        return (double)model->plan->misfit_spread;
    }
    double sum = 0.0;
    for (int u = model->first; u < model->end; u++) {
        for (int t = model->first; (t <= u) && davar_mixture_has(model, u); t++) {
            const double both = white_correlation(model->plan, t, u) * shared_by(model, t, u);
            sum += davar_mixture_has(model, t) ? (((t < u) ? 4.0 : 2.0) * square(both)) : 0.0;
        }
    }
    return davar_root(sum);
}

/* Factor for the variances of a model that does not fit, for example of a filtered sensor or a
 * sinusoid (5.9). */
static double inflation(const davar_mixture_t *model, const normal_t *normal, double misfit)
{
    const double freedom = (double)(normal->count - term_count(model->terms));
    const bool real = misfit > freedom + DAVAR_FIT_MISFIT * spread_of_misfit(model);
    return real ? misfit / ((freedom > 1.0) ? freedom : 1.0) : 1.0;
}

/* `tails`: of the term, see davar_mixture_t. */
DAVAR_APART static double lower_limit(double a, double variance, double tails)
{
    const double s = davar_root(0.5 * (variance / square(a) + tails));
    const double one = (double)(1U << NOISE_BITS);
    return a * (double)davar_chi_square_low((uint32_t)(((s < 1.0) ? s : 1.0) * one)) * (1.0 / one);
}

static double tails_of_term(const davar_mixture_t *model, int term)
{
    return (term == WHITE) ? model->tails : 0.0;
}

/* An unresolved term that may be present takes its share from the others: their intervals extend
 * down to the fit with it (5.10). `larger`: the term as large as it may be, over the one fitted. */
static void doubt(davar_mixture_t *model, const normal_t *normal, const inverse_t *inverse,
                  const matrix_t *h, double larger)
{
    for (int i = 0; i < inverse->size; i++) {
        const int k = inverse->term[i];
        if (has_term(model->terms, k)) {
            const double taken = model->a[k] - solution(normal, inverse, i);
            const double a = model->a[k] - larger * taken;
            const double variance = solution_variance(normal, inverse, h, i) * model->grow;
            const bool nothing = davar_root(0.5 * variance) >= DAVAR_FIT_NOTHING * a;
            const double low = nothing ? 0.0 : lower_limit(a, variance, tails_of_term(model, k));
            model->least[k] = (low < model->least[k]) ? low : model->least[k];
        }
    }
}

/* Weights and scatter are those of the model, so this tests the model without the term (a score
 * test). */
static void judge_absent(davar_mixture_t *model, const normal_t *normal, const matrix_t *h,
                         int term)
{
    inverse_t inverse;
    model->tried[term] = 0.0;
    model->variance[term] = (double)INFINITY;
    if (invert(normal, model->terms | term_bit(term), &inverse)) {
        const int i = term_count(model->terms & (term_bit(term) - 1U));
        model->tried[term] = solution(normal, &inverse, i);
        model->variance[term] = solution_variance(normal, &inverse, h, i) * model->grow;
        const double sigma = davar_root(model->variance[term]);
        if (model->tried[term] > DAVAR_FIT_DOUBT * sigma) {
            const double missed = (term > WHITE) ? DAVAR_FIT_MISSED * sigma : 0.0;
            doubt(model, normal, &inverse, h, 1.0 + davar_divide(missed, model->tried[term]));
        }
    }
}

/* Apart from judge: its inverse then takes no stack while judge_absent runs. */
DAVAR_APART static void judge_present(davar_mixture_t *model, const normal_t *normal,
                                      const matrix_t *h)
{
    inverse_t inverse;
    (void)invert(normal, model->terms, &inverse); /* succeeds as it did in the fit */
    for (int i = 0; i < inverse.size; i++) {
        const int k = inverse.term[i];
        model->variance[k] = solution_variance(normal, &inverse, h, i) * model->grow;
        model->least[k] = lower_limit(model->a[k], model->variance[k], tails_of_term(model, k));
    }
}

/* Fills tried, variance, least and grow. */
static void judge(davar_mixture_t *model)
{
    normal_t normal;
    matrix_t h;
    normal_equations(model, ALL_TERMS, 1.0, &normal);
    model->grow = inflation(model, &normal, scatter(model, &normal, &h));
    judge_present(model, &normal, &h);
    for (int k = 0; k < TERMS; k++) {
        if (!has_term(model->terms, k)) {
            judge_absent(model, &normal, &h, k);
        }
    }
}

/* --- selection --- */

/* A term in standard errors, without the factor of a misfit: terms are tested against the noise as
 * modelled. */
static double significance(const davar_mixture_t *model, int term)
{
    const double a = has_term(model->terms, term) ? model->a[term] : model->tried[term];
    return a / davar_root(model->variance[term] / model->grow);
}

static unsigned missing_terms(const davar_mixture_t *model)
{
    unsigned found = 0U;
    for (int k = 0; k < TERMS; k++) {
        found |= (!has_term(model->terms, k) && (significance(model, k) > DAVAR_FIT_THRESHOLD))
                     ? term_bit(k)
                     : 0U;
    }
    return found;
}

static void settle(davar_mixture_t *model)
{
    (void)converge(model, model->terms, 1.0, ROUNDS_FINAL);
    judge(model);
}

/* The part of the data that the model leaves unexplained, to compare models. */
static double unexplained(const davar_mixture_t *model)
{
    double sum = 0.0;
    for (int t = model->first; t < model->end; t++) {
        if (davar_mixture_has(model, t)) {
            double x[TERMS];
            sum +=
                weight_of(model, t) * loss(square(model->data->tau[t].adev) / avar_of(model, t, x));
        }
    }
    return sum;
}

/* Adds the one of `suspects` that explains most: drifts look alike, and the most significant one
 * may be the wrong one. -1: there is none, or the cluster sizes cannot separate it. */
static int add_best(davar_mixture_t *model, unsigned suspects)
{
    const davar_mixture_t before = *model;
    int best = -1;
    double least = (double)INFINITY;
    for (int k = 0; k < TERMS; k++) {
        davar_mixture_t trial = before;
        if (has_term(suspects, k) &&
            converge(&trial, before.terms | term_bit(k), 0.5, ROUNDS_TRIAL)) {
            const double left = unexplained(&trial);
            if (left < least) {
                least = left;
                best = k;
                *model = trial;
            }
        }
    }
    return best;
}

/* Removes `term` if it is not significant in addition to the others. The last one stays. */
static void reconsider(davar_mixture_t *model, int term)
{
    davar_mixture_t trial = *model;
    if (converge(&trial, model->terms & ~term_bit(term), 0.5, ROUNDS_TRIAL)) {
        settle(&trial);
        if (significance(&trial, term) < DAVAR_FIT_THRESHOLD) {
            *model = trial;
        }
    }
}

/* Adds a term and removes terms that it makes superfluous. False: nothing to add. */
static bool grow(davar_mixture_t *model, unsigned suspects)
{
    const int added = add_best(model, suspects);
    if (added < 0) {
        return false;
    }
    settle(model);
    for (int k = 0; k < TERMS; k++) {
        if (has_term(model->terms, k) && (k != added) &&
            (significance(model, k) < DAVAR_FIT_THRESHOLD)) {
            reconsider(model, k);
        }
    }
    return true;
}

DAVAR_RARE void davar_mixture_fit(davar_mixture_t *model, double white, unsigned suspects)
{
    model->rounding = davar_scaled_to_double(davar_rounding(&model->plan->white, model->data));
    model->tails = 2.0 * tails_of_size(model, model->first);
    model->terms = term_bit(WHITE);
    model->a[WHITE] = white;
    if (!grow(model, suspects)) {
        settle(model);
    }
    for (int round = 1; (round < TERMS) && grow(model, missing_terms(model));
         round++) { /* bounded: no cycles */
    }
    model->variance[WHITE] += model->tails * square(model->a[WHITE]);
}
