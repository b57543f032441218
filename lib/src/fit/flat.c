/* davar - white noise from the flat part of m avar, DESIGN (5.23): where slow motion lifts the long
 * cluster sizes, or an unknown filter lowers the short ones. Units: y = m avar / gain over a
 * reference, so that white noise is the constant N^2. */
#include "fit/plan.h"
#include "fit/white.h"
#include "number/real.h"

#define SIZES_MOVING 4  /* in motion: white noise, a ramp, and two that test them */
#define SIZES_FLAT 5    /* after a filter: flat for so many, of which the last ones are used, */
#define SIZES_SETTLED 3 /* ... at least so many */
#define SETTLED 4.0F    /* ... from this times the size from which the filter does not show */
#define VIBRATION_MOST 0.25F /* share of N^2 in the shortest of these sizes */
#define TREND_SHOWN 2.0F     /* standard errors of a trend that shows */
#define TREND_HIDDEN 4.0F    /* ... and of one that sizes chosen because it does not may hide */
#define MISFIT_REAL 3.0F     /* standard deviations of a misfit that is real */
#define OCTAVE_DOWN 2.0F
#define RELATIVE_MOST 0.125F /* variance of N^2 over N^4, above which it is no value */
#define INVERSE_LEAST 1e-9F  /* 1 / edf, below which N^2 is exact */
#define RATIO_MOST 1073741824.0F

/* Powers of m that y can have in addition to white noise. */
typedef enum { SETTLING = -1, NOTHING = 0, FLICKER_NOISE = 1, WALK = 2, RAMP = 3 } shape_t;

/* The Allan variances of a result as y. */
typedef struct {
    const davar_plan_t *plan;
    scaled_t unit;  /* of y */
    float rounding; /* of a sample */
    int count;
    float gain[DAVAR_TAUS_MAX];
    float offset[DAVAR_TAUS_MAX];  /* relative error of gain by one standard error */
    float level;                   /* relative error of all gains by another */
    float y[DAVAR_TAUS_MAX];       /* without rounding */
    float rounded[DAVAR_TAUS_MAX]; /* the rounding that was taken off */
    float inverse[DAVAR_TAUS_MAX]; /* 1 / effective differences */
} curve_t;

/* y = square + slope * shape at the sizes first to end - 1. */
typedef struct {
    int first;
    int end;
    float square; /* N^2 */
    float slope;
    float misfit;
    float shape[DAVAR_TAUS_MAX];
    float of_square[DAVAR_TAUS_MAX]; /* square is the sum of these times y */
    float of_slope[DAVAR_TAUS_MAX];
    float scatter[DAVAR_TAUS_MAX]; /* variance of y over that of white noise of variance 1 */
} line_t;

/* What is taken for the truth, which decides how y scatters: white noise and a ramp at the sizes
 * before `end`, as of the last of them. At the other sizes it is y itself. */
typedef struct {
    float square;
    float slope;
    int end;
} course_t;

static float float_square(float x)
{
    return x * x;
}

static float larger_of(float a, float b)
{
    return (a > b) ? a : b;
}

static float ratio_to_float(scaled_t ratio)
{
    if (ratio.exponent < -120) {
        return 0.0F;
    }
    return (ratio.exponent < -1) ? scaled_to_float(ratio) : RATIO_MOST;
}

static scaled_t y_of_size(const davar_plan_t *plan, const davar_result_t *result, int t)
{
    const scaled_t adev = scaled_of_double(result->tau[t].adev);
    return scaled_times(scaled_times(adev, adev), scaled_of_float(plan->white.to_white[t]));
}

/* False: too few sizes, or all differences of the shortest one are 0. */
static bool read_curve(const davar_plan_t *plan, const davar_result_t *result, curve_t *curve)
{
    const int usable = (int)davar_fit_usable(result);
    curve->plan = plan;
    curve->count = (usable < (int)plan->white.count) ? usable : (int)plan->white.count;
    if (curve->count < SIZES_MOVING) {
        return false;
    }
    curve->unit = y_of_size(plan, result, 0);
    if (curve->unit.mantissa == 0U) {
        return false;
    }
    curve->rounding =
        ratio_to_float(scaled_quotient(davar_rounding(&plan->white, result), curve->unit));
    curve->level = plan->level;
    for (int t = 0; t < curve->count; t++) {
        const float y = ratio_to_float(scaled_quotient(y_of_size(plan, result, t), curve->unit));
        curve->gain[t] = plan->gain[t];
        curve->offset[t] = plan->offset[t];
        curve->rounded[t] = curve->rounding / plan->gain[t];
        curve->y[t] = larger_of(y - curve->rounded[t], 0.0F);
        curve->inverse[t] = plan->freedom[t] / ratio_to_float(scaled_of_double(plan->edf[t]));
    }
    return true;
}

/* The same without the declared filter. */
static void forget_filter(curve_t *curve)
{
    curve->level = 0.0F;
    for (int t = 0; t < curve->count; t++) {
        curve->y[t] *= curve->gain[t];
        curve->rounded[t] *= curve->gain[t];
        curve->gain[t] = 1.0F;
        curve->offset[t] = 0.0F;
    }
}

/* (m / that of the last size)^shape over the gain. */
static float shape_at(const curve_t *curve, int t, int last, shape_t shape)
{
    const float ratio = curve->plan->m[t] / curve->plan->m[last];
    float power = (shape < 0) ? (1.0F / ratio) : 1.0F;
    for (int i = 0; i < (int)shape; i++) {
        power *= ratio;
    }
    return power / curve->gain[t];
}

/* The shift of y by one standard error of the filter, for white noise `square`. */
static float offset_at(const curve_t *curve, int t, float square)
{
    return curve->offset[t] * square;
}

/* Variance of y at one size, without that of the filter. */
static float variance_at(const curve_t *curve, const line_t *line, int t)
{
    return curve->plan->covariance[plan_pair(t, t)] * curve->inverse[t] * line->scatter[t];
}

/* White noise times motion adds to the scatter twice their product, since motion itself does not
 * scatter: of w^2 with white noise w alone, it makes w (2 y - w). */
static void prepare(const curve_t *curve, shape_t shape, const course_t *course, line_t *line)
{
    for (int t = line->first; t < line->end; t++) {
        const float white = course->square + curve->rounded[t];
        float y = curve->y[t];
        if (t < course->end) {
            y = course->square + (course->slope * shape_at(curve, t, course->end - 1, RAMP));
        }
        const float all = y + curve->rounded[t];
        line->scatter[t] = white * larger_of(2.0F * all - white, white);
        line->shape[t] = shape_at(curve, t, line->end - 1, shape);
    }
}

/* Weighted least squares. In motion, a slope below 0 is chance and becomes 0. */
static void solve_line(const curve_t *curve, shape_t shape, float before, line_t *line)
{
    float s0 = 0.0F;
    float s1 = 0.0F;
    float s2 = 0.0F;
    float y0 = 0.0F;
    float y1 = 0.0F;
    for (int t = line->first; t < line->end; t++) {
        const float s = line->shape[t];
        const float weight =
            1.0F / (variance_at(curve, line, t) + float_square(offset_at(curve, t, before)));
        const float weighted = weight * s;
        line->of_square[t] = weight;
        s0 += weight;
        s1 += weighted;
        s2 += weighted * s;
        y0 += weight * curve->y[t];
        y1 += weighted * curve->y[t];
    }
    if ((shape == NOTHING) || ((shape > NOTHING) && !(s0 * y1 > s1 * y0))) {
        s1 = 0.0F;
        s2 = 1.0F;
        y1 = 0.0F;
    }
    const float inverse = 1.0F / (s0 * s2 - s1 * s1);
    line->square = (s2 * y0 - s1 * y1) * inverse;
    line->slope = (s0 * y1 - s1 * y0) * inverse;
    for (int t = line->first; t < line->end; t++) {
        const float weight = line->of_square[t] * inverse;
        line->of_slope[t] = weight * (s0 * line->shape[t] - s1);
        line->of_square[t] = weight * (s2 - s1 * line->shape[t]);
    }
}

/* The sum of squared residuals in standard errors. Of the uncertain filter, which moves all sizes
 * together, any multiple of one standard error may explain them. */
static float misfit_of(const curve_t *curve, const line_t *line)
{
    float sum = 0.0F;
    float along = 0.0F;
    float norm = 1.0F;
    for (int t = line->first; t < line->end; t++) {
        const float rest = curve->y[t] - line->square - line->slope * line->shape[t];
        const float offset = offset_at(curve, t, line->square);
        const float inverse = 1.0F / variance_at(curve, line, t);
        sum += float_square(rest) * inverse;
        along += offset * rest * inverse;
        norm += float_square(offset) * inverse;
    }
    return sum - float_square(along) / norm;
}

static float flat_covariance(const curve_t *curve, int t, int u)
{
    return curve->plan->covariance[plan_pair(t, u)] * curve->inverse[t]; /* t <= u */
}

/* Does the line leave no real misfit? Its variance is twice the sum of the squared correlations. */
static bool line_explains(const curve_t *curve, const line_t *line)
{
    const float sizes = (float)(line->end - line->first);
    const float freedom = sizes - 2.0F;
    const float above = line->misfit - freedom;
    float sum = sizes;
    for (int u = line->first; u < line->end; u++) {
        for (int t = line->first; t < u; t++) {
            sum += 2.0F * float_square(flat_covariance(curve, t, u)) /
                   (flat_covariance(curve, t, t) * flat_covariance(curve, u, u));
        }
    }
    return !(above > 0.0F) ||
           !(float_square(above) > float_square(MISFIT_REAL) * 2.0F * sum * (freedom / sizes));
}

/* Variance of a sum of factor[t] y[t]. */
static float flat_variance(const curve_t *curve, const line_t *line, const float factor[])
{
    const float level = curve->level * line->square;
    float weight[DAVAR_TAUS_MAX];
    float sum = 0.0F;
    float offset = 0.0F;
    for (int u = line->first; u < line->end; u++) {
        float row = 0.0F;
        for (int t = line->first; t < u; t++) {
            row += flat_covariance(curve, t, u) * weight[t];
        }
        weight[u] = scaled_root_of_float(line->scatter[u]) * factor[u];
        sum += weight[u] * (2.0F * row + flat_covariance(curve, u, u) * weight[u]);
        offset += offset_at(curve, u, line->square) * factor[u];
    }
    return larger_of(sum, 0.0F) + (float)DAVAR_FIT_AXIS_MARGIN * float_square(offset) +
           float_square(level);
}

/* Fits the sizes first to end - 1. False: there is no white noise in it, or the line does not
 * explain them. */
static bool fit_line(const curve_t *curve, int first, int end, shape_t shape,
                     const course_t *course, line_t *line)
{
    line->first = first;
    line->end = end;
    prepare(curve, shape, course, line);
    solve_line(curve, shape, course->square, line);
    line->misfit = misfit_of(curve, line);
    return (line->square > 0.0F) && line_explains(curve, line);
}

/* The sizes below `end` that are at most m. */
static int end_at(const curve_t *curve, int end, float m)
{
    while ((end > 0) && (curve->plan->m[end - 1] > m)) {
        end--;
    }
    return end;
}

/* In motion, which is smooth, so that it is a ramp at short sizes: as many sizes as white noise and
 * a ramp explain, less one octave, in which what the test misses is largest. */
static bool fit_moving(const curve_t *curve, course_t *course, line_t *line)
{
    int end = SIZES_MOVING;
    *course = (course_t){.square = curve->y[0]};
    for (int t = 1; t < SIZES_MOVING; t++) {
        course->square = (curve->y[t] < course->square) ? curve->y[t] : course->square;
    }
    (void)fit_line(curve, 0, end, RAMP, course, line); /* how the sizes scatter */
    *course = (course_t){larger_of(line->square, course->square), line->slope, end};
    while ((end <= curve->count) && fit_line(curve, 0, end, RAMP, course, line)) {
        *course = (course_t){line->square, line->slope, end};
        end++;
    }
    if (end > curve->count) {
        return true;
    }
    end = end_at(curve, end - 1, curve->plan->m[end - 2] / OCTAVE_DOWN);
    return (end >= SIZES_MOVING) && fit_line(curve, 0, end, RAMP, course, line);
}

/* After a filter that is not the declared one, or in fast vibration: the sizes from four times
 * the first one on from which y shows no trend as 1 / m, as which both end. */
static bool fit_settled(const curve_t *curve, line_t *line, line_t *trend)
{
    for (int first = 0; (curve->count - first) >= SIZES_FLAT; first++) {
        course_t course = {.square = curve->y[curve->count - 1]};
        (void)fit_line(curve, first, curve->count, NOTHING, &course, line); /* how they scatter */
        course.square = line->square;
        if (fit_line(curve, first, curve->count, SETTLING, &course, trend) &&
            !(float_square(trend->slope) >
              float_square(TREND_SHOWN) * flat_variance(curve, trend, trend->of_slope))) {
            const float m = curve->plan->m[first] * SETTLED;
            while ((first < curve->count) && (curve->plan->m[first] < m)) {
                first++;
            }
            return ((curve->count - first) >= SIZES_SETTLED) &&
                   fit_line(curve, first, curve->count, NOTHING, &course, line);
        }
    }
    return false;
}

/* 1 / edf of N^2, heavy tails included (5.19). */
static float inverse_edf(const curve_t *curve, const line_t *line)
{
    const float tails = (float)(DAVAR_LAWS ? curve->plan->white.white_tails : 0U);
    return (flat_variance(curve, line, line->of_square) / (2.0F * float_square(line->square))) +
           (tails / (float)(UINT32_C(1) << NOISE_BITS));
}

/* White noise from a part of the sizes, with its 95 % limits. */
typedef struct {
    int first;
    int last;
    float square;
    float low;
    float high;
} flat_part_t;

static flat_part_t part_of_line(const curve_t *curve, const line_t *line)
{
    const float inverse = inverse_edf(curve, line);
    const float most = (inverse < 1.0F) ? inverse : 1.0F;
    scaled_t low;
    scaled_t high;
    davar_chi_square(scaled_inverse(scaled_of_float(larger_of(most, INVERSE_LEAST))), &low, &high);
    return (flat_part_t){line->first, line->end - 1, line->square,
                         line->square * scaled_to_float(low), line->square * scaled_to_float(high)};
}

/* Is the noise at least what rounding may hide, and known well enough to be a value? */
static bool is_value(const curve_t *curve, const line_t *line)
{
    const float coarse = (float)curve->plan->white.coarse / (float)(UINT32_C(1) << NOISE_BITS);
    return (curve->rounding < coarse * line->square) &&
           (2.0F * inverse_edf(curve, line) < RELATIVE_MOST);
}

/* If slow noise instead of motion explains the same sizes, it leaves less white noise. */
static bool find_moving(const curve_t *curve, flat_part_t *part)
{
    course_t course;
    line_t line;
    if (!fit_moving(curve, &course, &line) || !is_value(curve, &line)) {
        return false;
    }
    *part = part_of_line(curve, &line);
    for (int shape = (int)WALK; shape >= (int)FLICKER_NOISE; shape--) {
        line_t other;
        if (fit_line(curve, line.first, line.end, (shape_t)shape, &course, &other)) {
            const float low = part_of_line(curve, &other).low;
            part->low = (low < part->low) ? low : part->low;
        }
    }
    return true;
}

/* Vibration leaves at most about as much in m^2 avar as at the shorter sizes: up to this at the
 * shortest of the line. */
static float vibration_most(const curve_t *curve, const line_t *line)
{
    const float *const m = curve->plan->m;
    float most = 0.0F;
    for (int t = 0; t < line->first; t++) {
        most = larger_of(most, (curve->y[t] - line->square) * m[t]);
    }
    return most / m[line->first];
}

/* The trend that does not show may be there, and vibration too. */
static bool find_settled(const curve_t *curve, flat_part_t *part)
{
    line_t line;
    line_t trend;
    if (!fit_settled(curve, &line, &trend) || !is_value(curve, &line)) {
        return false;
    }
    const float error = scaled_root_of_float(flat_variance(curve, &trend, trend.of_square));
    const float vibration = vibration_most(curve, &line);
    *part = part_of_line(curve, &line);
    part->low = larger_of(part->low - vibration, 0.0F);
    part->high = larger_of(part->high, trend.square + TREND_HIDDEN * error);
    return vibration < VIBRATION_MOST * line.square;
}

static double flat_in_unit(const curve_t *curve, float square)
{
    const scaled_t root = davar_scaled_root(scaled_times(scaled_of_float(square), curve->unit));
    return davar_scaled_to_double(scaled_times(root, scaled_of_double(curve->plan->root[WHITE])));
}

static void write_part(const curve_t *curve, const flat_part_t *part, davar_result_t *result)
{
    result->coefficient[WHITE] =
        (davar_coefficient_t){true, flat_in_unit(curve, part->square),
                              flat_in_unit(curve, part->low), flat_in_unit(curve, part->high)};
    result->flat_from = result->tau[part->first].m;
    result->flat_to = result->tau[part->last].m;
}

/* Long sizes that settle may be white noise after a narrower filter than the declared one, and they
 * may be motion that looks like noise. They limit white noise, and if they contradict the short
 * sizes, neither gives a value. */
static void flat_mixed(const davar_plan_t *plan, curve_t *curve, davar_result_t *result)
{
    double *const high = &result->coefficient[WHITE].high;
    flat_part_t moving;
    flat_part_t settled;
    const bool moves = plan->white.declared && find_moving(curve, &moving);
    forget_filter(curve);
    const bool settles = find_settled(curve, &settled);
    if (moves && !(settles && (moving.high < settled.low))) {
        write_part(curve, &moving, result);
    } else if (settles) {
        const double limit = flat_in_unit(curve, settled.high);
        *high = (*high < limit) ? limit : *high;
    } else {
        /* the limit stays */
    }
}

static void flat_filtered(curve_t *curve, davar_result_t *result)
{
    flat_part_t settled;
    forget_filter(curve);
    if (find_settled(curve, &settled)) {
        write_part(curve, &settled, result);
    }
}

bool davar_fit_flat(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    const bool mixed = (result->noise == DAVAR_NOISE_MIXED);
    const bool filtered = (result->noise == DAVAR_NOISE_FILTERED);
    const bool present = result->coefficient[WHITE].present;
    curve_t curve;
    result->flat_from = 0U;
    result->flat_to = 0U;
    if (!present && (mixed || filtered) && read_curve(plan, result, &curve)) {
        davar_plan_rate(plan, rate_hz);
        if (mixed) {
            flat_mixed(plan, &curve, result);
        } else {
            flat_filtered(&curve, result);
        }
    }
    return result->coefficient[WHITE].present;
}
