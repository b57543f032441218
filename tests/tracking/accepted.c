#include "accepted.h"

#include <math.h>
#include <string.h>

void accepted_start(accepted_t *accepted, const davar_config_t *config)
{
    const davar_glr_wish_t wish = {.rate_hz = config->rate_hz,
                                   .false_alarms_per_hour = config->glr.false_alarms_per_hour,
                                   .cut_interval_s = config->glr.cut_interval_s,
                                   .longest = config->window.longest,
                                   .block = config->glr.block,
                                   .shock = config->glr.shock_blocks};
    memset(accepted, 0, sizeof *accepted);
    accepted->is_behind_boundary = true;
    accepted->first = config->glr.whiten_first;
    accepted->second = config->glr.whiten_second;
    accepted->is_q31 = (config->law == &davar_law_glr_q31);
    accepted->has_detector = accepted->is_q31 || (config->law == &davar_law_glr_q15);
    if (!accepted->has_detector) {
        return;
    }
    davar_glr_start(&accepted->config, &wish);
    accepted->config.floor =
        davar_glr_floor(config->glr.block, config->glr.whiten_first, config->glr.whiten_second);
    davar_glr_reset(&accepted->detector);
}

static void accept(accepted_t *accepted, int32_t sample, uint64_t moment)
{
    const uint64_t n = accepted->count % ACCEPTED_RING;
    const uint64_t before = (accepted->count + ACCEPTED_RING - 1U) % ACCEPTED_RING;
    accepted->phase[n] = accepted->phase[before] + sample;
    accepted->run[n] = accepted->is_behind_boundary ? 1U : (accepted->run[before] + 1U);
    accepted->moment[n] = moment;
    accepted->is_behind_boundary = false;
    accepted->count++;
}

/* The waiting samples from `first` onward become part of the record; all before them are
 * dropped. */
static void accept_waiting(accepted_t *accepted, uint32_t first)
{
    accepted->is_behind_boundary = accepted->is_behind_boundary || (first > 0U);
    for (uint32_t i = first; i < accepted->waits; i++) {
        accept(accepted, accepted->waiting[i], accepted->now - accepted->waits + i);
    }
    accepted->waits = 0U;
}

static void hear_block(accepted_t *accepted)
{
    const uint32_t block = accepted->config.block;
    davar_glr_event_t event;
    int64_t sum = 0;
    davar_u128_t squares = {0U, 0U};
    for (uint32_t i = 0U; i < block; i++) {
        sum += accepted->rest[i];
        const uint64_t square = (uint64_t)((int64_t)accepted->rest[i] * accepted->rest[i]);
        squares.low += square;
        squares.high += (squares.low < square) ? 1U : 0U;
    }
    davar_glr_push_q31(&accepted->detector, &accepted->config, sum, &squares, &event);
    accepted->cuts += event.is_cut ? 1U : 0U;
    accepted->alarms += event.is_alarm ? 1U : 0U;
    accepted->shocks += (event.dropped > 0U) ? 1U : 0U;
    if (event.resolved > 0U) { /* all waiting samples */
        accept_waiting(accepted, event.dropped * block);
    }
}

/* What the two samples before it do not predict. Products and sums of 53 bits are exact. */
static int32_t whitened(accepted_t *accepted, int32_t sample)
{
    const double most = accepted->is_q31 ? 2147483647.0 : 32767.0;
    const int32_t newer = accepted->has_past ? accepted->before[0] : sample;
    const int32_t older = accepted->has_past ? accepted->before[1] : sample;
    const double predicted = ((double)accepted->first * newer) + ((double)accepted->second * older);
    const double rest = sample - floor((predicted / 16384.0) + 0.5);
    accepted->before[0] = sample;
    accepted->before[1] = newer;
    accepted->has_past = true;
    return (int32_t)fmax(-most - 1.0, fmin(most, rest));
}

void accepted_hear(accepted_t *accepted, int32_t sample)
{
    if (!accepted->has_detector) {
        accept(accepted, sample, accepted->now);
        accepted->now++;
        return;
    }
    accepted->rest[accepted->waits % accepted->config.block] = whitened(accepted, sample);
    accepted->waiting[accepted->waits] = sample;
    accepted->waits++;
    accepted->now++;
    if ((accepted->waits % accepted->config.block) == 0U) {
        hear_block(accepted);
    }
}

void accepted_gap(accepted_t *accepted)
{
    davar_glr_event_t event;
    if (accepted->has_detector) {
        davar_glr_skip(&accepted->detector, &accepted->config, &event);
    }
    accepted->waits = 0U;
    accepted->has_past = false;
    accepted->is_behind_boundary = true;
}

void accepted_end(accepted_t *accepted)
{
    if (accepted->detector.pending == 0U) {
        accept_waiting(accepted, 0U);
    }
}

uint64_t accepted_head(const accepted_t *accepted, uint64_t epoch)
{
    const uint64_t oldest =
        (accepted->count > ACCEPTED_RING) ? (accepted->count - ACCEPTED_RING) : 0U;
    uint64_t head = accepted->count;
    while ((head > oldest) && (accepted->moment[(head - 1U) % ACCEPTED_RING] > epoch)) {
        head--;
    }
    return ((head > oldest) && (accepted->moment[(head - 1U) % ACCEPTED_RING] == epoch)) ? head
                                                                                         : 0U;
}

double accepted_sum(const accepted_t *accepted, uint64_t tail, uint64_t head, uint32_t m,
                    uint32_t *differences)
{
    uint64_t low = 0U; /* 53 bits, and what they carry */
    uint64_t high = 0U;
    *differences = 0U;
    for (uint64_t last = tail + (UINT64_C(2) * m) - 1U; last < head; last++) {
        if (accepted->run[last % ACCEPTED_RING] >=
            (2U * m)) { /* before the first sample the sum is 0, as it was then */
            const uint64_t middle = last + ACCEPTED_RING - m;
            const int64_t d = accepted->phase[last % ACCEPTED_RING] -
                              (2 * accepted->phase[middle % ACCEPTED_RING]) +
                              accepted->phase[(middle - m) % ACCEPTED_RING];
            low += (uint64_t)(d * d); /* |d| below 2^31 */
            high += low >> 53U;
            low &= (UINT64_C(1) << 53U) - 1U;
            (*differences)++;
        }
    }
    return ldexp((double)high, 53) + (double)low;
}
