/* davar - the small pipeline: octaves in a fixed window of int16 counts that no gap interrupts.
 * Formulas: lib/DESIGN.md (1.1) (2.1) (2.2) (4.5). */
#include "davar/small.h"

#include "deviation.h"

#include "number/machine.h"
#include "number/scaled.h"
#include "number/sequence.h"

#define EQUAL_MOST (UINT32_MAX / 2U) /* the count of equal samples never overflows */

/* --- a sample in ------------------------------------------------------------------------------ */

/* The sample that is `age` samples older than the newest one; 0 before the window's start. */
static int32_t sample_of_age(const davar_small_t *small, uint32_t age)
{
    if (age > small->length) {
        return 0;
    }
    const uint32_t at = small->newest;
    return small->ring[at - age + ((at < age) ? (small->plan->fit.window + 1U) : 0U)];
}

/* The leading edge has moved to the newest sample, and the trailing edge too if the window was
 * full. `length` does not count the newest sample yet. Octaves share samples: the oldest one of a
 * span is the middle one of the next span. */
static void move_window(davar_small_t *small)
{
    const uint32_t window = small->plan->fit.window;
    const uint32_t length = small->length;
    const int32_t newest = sample_of_age(small, 0U);
    const int32_t oldest = sample_of_age(small, window);
    int32_t before = sample_of_age(small, 1U);
    int32_t after = sample_of_age(small, window - 1U);
    uint32_t span = 2U;
    for (int t = 0; t < (int)small->plan->fit.count; t++) {
        davar_small_tau_t *const tau = &small->tau[t];
        int32_t trailing = 0; /* the span that leaves */
        if (length == 0U) {
            tau->head = 0;
            tau->sum = 0U;
        }
        tau->head += newest - (2 * before);
        before = sample_of_age(small, span);
        tau->head += before;
        if (length == window) {
            trailing = tau->tail;
            tau->tail += oldest - (2 * after);
            after = sample_of_age(small, window - span);
            tau->tail += after;
        }
        if ((length + 1U) == span) {
            tau->tail = tau->head;
        }
        if ((length + 1U) >= span) {
            tau->sum += davar_multiply_i32(tau->head - trailing, tau->head + trailing);
        }
        span *= 2U;
    }
}

/* Has the first sum changed since a window half a window ago or more (4.5)? */
static bool noise_changed(davar_small_t *small)
{
    const uint32_t window = small->plan->fit.window;
    const uint32_t level =
        (small->length == window) ? scaled_level(scaled_of_u64(small->tau[0].sum, 0)) : 0U;
    if (small->past <= small->plan->stride) {
        small->level[1] = small->level[0];
        small->level[0] = level;
        small->past = (window + 1U) / 2U;
    } else {
        small->past -= small->plan->stride;
    }
    return (small->level[1] > 0U) && davar_levels_differ(level, small->level[1], window);
}

/* A result is due. */
static void complete_epoch(davar_small_t *small)
{
    small->waited = 0U;
    small->kept_equal = small->equal;
    small->equal = (small->equal < EQUAL_MOST) ? small->equal : EQUAL_MOST;
    small->unstable = noise_changed(small);
    if (small->length < small->plan->fit.window) {
        return;
    }
    for (int t = 0; t < (int)small->plan->fit.count; t++) {
        small->tau[t].kept = small->tau[t].sum;
    }
    small->epoch = small->now - 1U;
    small->ready = true;
    small->produced = small->produced + 1U;
}

static void push_one(davar_small_t *small, int16_t sample)
{
    small->now++;
    if ((sample == INT16_MAX) || (sample == INT16_MIN)) {
        davar_count(&small->saturated);
    }
    if (small->skip > 0U) {
        small->skip--;
        return;
    }
    const uint32_t last = small->newest;
    const bool equal = (small->length > 0U) && (sample == small->ring[last]);
    small->equal = equal ? (small->equal + 1U) : 1U;
    small->newest = (last >= small->plan->fit.window) ? 0U : (last + 1U);
    small->ring[small->newest] = sample;
    move_window(small);
    if (small->length < small->plan->fit.window) {
        small->length++;
    }
    small->waited++;
    if (small->waited == small->plan->stride) {
        complete_epoch(small);
    }
}

void davar_small_push(davar_small_t *small, const int16_t *counts, size_t count)
{
    davar_sequence_begin(&small->sequence);
    for (size_t i = 0U; i < count; i++) {
        push_one(small, counts[i]);
    }
    davar_sequence_end(&small->sequence);
}

/* --- gaps ------------------------------------------------------------------------------------- */

/* Forgets the window. Samples before the next epoch are omitted, so that epochs stay where they
 * were due. */
static void restart(davar_small_t *small)
{
    small->skip = (small->waited == 0U) ? 0U : (small->plan->stride - small->waited);
    small->waited = 0U;
    small->length = 0U;
    small->level[0] = 0U;
    small->level[1] = 0U;
    small->past = 0U;
    small->ready = false;
}

void davar_small_gap(davar_small_t *small, uint32_t missing)
{
    davar_sequence_begin(&small->sequence);
    davar_count_many(&small->missing, missing);
    davar_count(&small->gaps);
    if (small->length > 0U) {
        davar_count(&small->restarts);
        restart(small);
    }
    davar_sequence_end(&small->sequence);
}

void davar_small_restart(davar_small_t *small)
{
    const davar_small_t fresh = {.plan = small->plan, .ring = small->ring};
    *small = fresh;
}

/* --- start ------------------------------------------------------------------------------------ */

void davar_small_start(davar_small_t *small, const davar_small_plan_t *plan, int16_t *ring)
{
    small->plan = plan;
    small->ring = ring;
}

/* --- a result out ----------------------------------------------------------------------------- */

static uint32_t results_missed(const davar_small_t *small, uint32_t produced, bool waits)
{
    uint32_t missed = small->missed;
    davar_count_many(&missed, (produced - small->seen) - (waits ? 1U : 0U));
    return missed;
}

static bool is_waiting(const davar_small_t *small)
{
    return small->ready && (small->produced != small->seen);
}

/* (1.1) */
static double deviation_in_dps(const davar_small_plan_t *plan, uint64_t sum,
                               const davar_adev_t *tau)
{
    const uint64_t divisor = davar_multiply_u32(2U * tau->m * tau->m, tau->differences);
#ifdef DAVAR_SOFT_DOUBLE
    return davar_deviation_by_digits(sum, divisor, plan->unit_per_count);
#else
    return sqrt((double)sum / (double)divisor) * plan->unit_per_count;
#endif
}

/* Everything but what the fit writes. */
static void describe(const davar_small_plan_t *plan, const uint64_t sum[], davar_result_t *result)
{
    result->window_samples = plan->fit.window;
    result->mirrored_samples = 0U;
    result->gaps_in_window = 0U;
    result->chosen = false;
    result->tau_count = plan->fit.count;
    result->unit_per_count = plan->unit_per_count;
    result->kurtosis = (double)NAN;
    result->contribution = (double)NAN;
    result->dispersion = (double)NAN;
    for (uint32_t t = 0U; t < plan->fit.count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        tau->m = UINT32_C(1) << t;
        tau->differences = plan->fit.window + 1U - (2U * tau->m);
        tau->hops = 0U;
        tau->adev = deviation_in_dps(plan, sum[t], tau);
    }
}

/* Copies what a push changes. */
static void copy_result(const davar_small_t *small, uint64_t sum[], davar_result_t *result)
{
    result->epoch = small->epoch;
    result->equal_samples = small->kept_equal;
    result->unstable = small->unstable;
    for (int t = 0; t < (int)small->plan->fit.count; t++) {
        sum[t] = small->tau[t].kept;
    }
}

bool davar_small_take(davar_small_t *small, davar_result_t *result)
{
    uint64_t sum[DAVAR_TAUS_MAX];
    uint32_t before;
    uint32_t produced;
    bool found;
    do {
        before = davar_sequence_read(&small->sequence);
        produced = small->produced;
        found = is_waiting(small);
        if (found) {
            copy_result(small, sum, result);
        }
    } while (davar_sequence_torn(&small->sequence, before));
    small->missed = results_missed(small, produced, found);
    small->seen = produced;
    if (found) {
        describe(small->plan, sum, result);
        (void)davar_fit_walk(&small->plan->fit, result);
    }
    return found;
}

davar_health_t davar_small_health(const davar_small_t *small)
{
    davar_health_t health = {0};
    uint32_t before;
    do {
        before = davar_sequence_read(&small->sequence);
        health.gaps = small->gaps;
        health.missing = small->missing;
        health.saturated = small->saturated;
        health.restarts = small->restarts;
        health.missed = results_missed(small, small->produced, is_waiting(small));
    } while (davar_sequence_torn(&small->sequence, before));
    return health;
}
