/* davar tests - brute force. */
#include "reference.h"

#include <math.h>

#define NO_LEVEL (-64.0) /* of no window, or of a sum of 0 */

static int64_t reflected(const reference_record_t *record, int64_t position)
{
    if (position < 0) {
        return -1 - position;
    }
    return (position < record->count) ? position : ((2 * record->count) - 1 - position);
}

int64_t reference_sample(const reference_record_t *record, int64_t position)
{
    return record->sample[reflected(record, position)];
}

/* True if there is a gap between the samples at position - 1 and position. */
static bool gap_at(const reference_record_t *record, int64_t position)
{
    if (record->gap_before == NULL) {
        return false;
    }
    while ((position < 0) || (position > record->count)) { /* a mirror image */
        position = (position < 0) ? -position : ((2 * record->count) - position);
    }
    return (position != 0) && (position != record->count) && record->gap_before[position];
}

void reference_start(reference_t *reference, const davar_config_t *config, bool is_centred,
                     reference_record_t record)
{
    reference->config = config;
    reference->is_centred = is_centred;
    reference->record = record;
    reference->due_epoch = (int64_t)config->stride - 1;
    const bool longest = is_centred || (config->stride > config->window.longest);
    reference->length = longest ? (int64_t)config->window.longest : (int64_t)config->stride;
    reference->filling = !is_centred;
    reference->level[0] = NO_LEVEL;
    reference->level[1] = NO_LEVEL;
    reference->wait = 0;
}

static reference_real_t kurtosis_of(const reference_record_t *record, int64_t from, int64_t to)
{
    const reference_real_t n = (reference_real_t)(to - from);
    reference_real_t mean = 0;
    for (int64_t i = from; i < to; i++) {
        mean += (reference_real_t)reference_sample(record, i) / n;
    }
    reference_real_t second = 0;
    reference_real_t fourth = 0;
    bool constant = true;
    for (int64_t i = from; i < to; i++) {
        const reference_real_t deviation = (reference_real_t)reference_sample(record, i) - mean;
        second += deviation * deviation;
        fourth += deviation * deviation * deviation * deviation;
        constant = constant && (reference_sample(record, i) == reference_sample(record, from));
    }
    return constant ? (reference_real_t)NAN : ((fourth / n) / ((second / n) * (second / n)));
}

static bool outside(reference_real_t value, double low, double high)
{
    return (value < (reference_real_t)low) || (value > (reference_real_t)high);
}

static void judge(const reference_t *reference, reference_epoch_t *epoch)
{
    const davar_config_t *const config = reference->config;
    const reference_record_t *const record = &reference->record;
    const reference_real_t whole = kurtosis_of(record, epoch->tail, epoch->head);
    const reference_real_t first =
        kurtosis_of(record, epoch->tail, epoch->head - (int64_t)config->moments.segment);
    const reference_real_t change = (whole > first) ? (whole - first) : (first - whole);
    const reference_real_t contribution = change / whole;
    const bool f1 = outside(whole, config->moments.kurtosis_low, config->moments.kurtosis_high);
    const bool f2 =
        outside(contribution, config->moments.contribution_low, config->moments.contribution_high);
    epoch->kurtosis = (double)whole;
    epoch->contribution = (double)contribution;
    epoch->unstable = f1 || f2;
    if (config->law == &davar_law_kurtosis) {
        epoch->unstable = f1;
    }
    if (config->law == &davar_law_and) {
        epoch->unstable = f1 && f2;
    }
}

static int64_t smaller(int64_t a, int64_t b)
{
    return (a < b) ? a : b;
}

static int64_t larger(int64_t a, int64_t b)
{
    return (a > b) ? a : b;
}

static void decide(reference_t *reference, bool unstable)
{
    const davar_config_t *const config = reference->config;
    const bool fixed = (config->law == NULL);
    const bool trailing = !reference->is_centred;
    const int64_t stride = config->stride;
    int64_t grow = config->window.grow;
    if (trailing) {
        grow = (reference->filling || fixed) ? 1 : smaller(grow, 1);
    }
    if (unstable && !fixed) {
        reference->filling = false;
        reference->length = larger(config->window.shortest,
                                   reference->length - ((int64_t)config->window.shrink * stride));
    } else {
        reference->filling =
            reference->filling && (reference->length < (int64_t)config->window.longest);
        grow = (trailing && !reference->filling && !fixed) ? smaller(config->window.grow, 1) : grow;
        reference->length = smaller(config->window.longest, reference->length + (grow * stride));
    }
}

/* log2 with straight lines between powers of two, to 20 bits. */
static double level_of(double sum)
{
    int exponent;
    const double part = frexp(sum, &exponent); /* 0.5 to 1 */
    return (sum > 0.0) ? (exponent + (floor(((2.0 * part) - 1.0) * 0x1p20) / 0x1p20)) : NO_LEVEL;
}

/* Is this window unlike the one half a window before the last that was kept (4.5)? */
static bool has_changed(reference_t *reference, const reference_epoch_t *epoch, bool reported)
{
    const davar_config_t *const config = reference->config;
    const int64_t longest = config->window.longest;
    const double even = log2((double)longest) / 2.0;
    const double limit = 16.0 * pow(2.0, -floor(even)) * ((floor(even) < even - 0.49) ? 0.75 : 1.0);
    uint32_t count;
    const double sum = (double)reference_sum(reference, epoch, config->taus[0], &count);
    const bool full = ((epoch->head - epoch->tail) == longest) && (epoch->tail >= 0) &&
                      (epoch->head <= reference->record.count);
    if (reference->wait > (int64_t)config->stride) {
        reference->wait -= (int64_t)config->stride;
    } else {
        reference->level[1] = reference->level[0];
        reference->level[0] = (full && (sum > 0.0)) ? level_of(sum) : NO_LEVEL;
        reference->wait = (longest + 1) / 2;
    }
    const bool comparable = reported && full && (longest >= 64) && (config->taus[0] == 1U);
    return comparable && (reference->level[1] > NO_LEVEL) &&
           (fabs(level_of(sum) - reference->level[1]) > limit);
}

bool reference_next(reference_t *reference, reference_epoch_t *epoch)
{
    const davar_config_t *const config = reference->config;
    const bool centred = reference->is_centred;
    if (centred && (reference->record.count < (int64_t)(config->window.longest / 2))) {
        return false;
    }
    while (reference->due_epoch < reference->record.count) {
        const int64_t length = reference->length;
        epoch->epoch = reference->due_epoch;
        epoch->head = centred ? (epoch->epoch + (length / 2)) : (epoch->epoch + 1);
        epoch->tail = epoch->head - length;
        epoch->filling = reference->filling;
        reference->due_epoch += config->stride;
        const bool reported = centred || (length >= (int64_t)config->window.shortest);
        epoch->unstable = false;
        epoch->kurtosis = (double)NAN;
        epoch->contribution = (double)NAN;
        if (reported && (config->moments.segment > 0U)) {
            judge(reference, epoch);
        }
        if ((config->law == NULL) && has_changed(reference, epoch, reported)) {
            epoch->unstable = true;
        }
        decide(reference, epoch->unstable && reported);
        if (reported) {
            return true;
        }
    }
    return false;
}

reference_real_t reference_sum(const reference_t *reference, const reference_epoch_t *epoch,
                               uint32_t m, uint32_t *differences)
{
    const reference_record_t *const record = &reference->record;
    reference_real_t sum = 0;
    *differences = 0U;
    for (int64_t start = epoch->tail; (start + (2 * (int64_t)m)) <= epoch->head; start++) {
        int64_t difference = 0;
        bool gap = false;
        for (int64_t i = 0; i < (int64_t)m; i++) {
            difference += reference_sample(record, start + (int64_t)m + i) -
                          reference_sample(record, start + i);
        }
        for (int64_t i = 1; i < (2 * (int64_t)m); i++) {
            gap = gap || gap_at(record, start + i);
        }
        if (!gap) {
            sum += (reference_real_t)difference * (reference_real_t)difference;
            (*differences)++;
        }
    }
    return sum;
}
