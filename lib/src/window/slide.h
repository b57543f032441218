/* davar - the whole window moves by one sample: where a value at every sample spends its time (2.2). */
#ifndef DAVAR_SRC_SLIDE_H
#define DAVAR_SRC_SLIDE_H

#include "window/stages.h"

/* Any cluster sizes. Few live values, so that they stay in registers. */
DAVAR_APART static void slide_any(allan_t *allan, const sample_t *head, const sample_t *tail)
{
    const uint32_t *m = allan->m;
    tau_t *tau = allan->tau;
    const tau_t *const end = tau + allan->count;
    const difference_t newest = (difference_t)*head;
    const difference_t oldest = (difference_t)*tail;
    for (; tau != end; tau++, m++) {
        const size_t lag = *m;
        const difference_t trailing = tau->tail;
        tau->tail = trailing + oldest - (2 * (difference_t)tail[lag]) + tail[2U * lag];
        const sample_t *const before = head - (2U * lag);
        const difference_t leading = tau->head + newest - (2 * (difference_t)before[lag]) + *before;
        tau->head = leading;
        sum_slide(&tau->sum, leading, trailing);
    }
}

#if defined(__GNUC__) && defined(__ARM_ARCH_PROFILE) && (__ARM_ARCH_PROFILE == 'M') && (__ARM_ARCH_ISA_THUMB == 2) &&  \
    !defined(__ARM_BIG_ENDIAN) && (NUMBER_SUM_BITS == 64U) && !defined(DAVAR_PORTABLE)
#include "window/slide_armv7m.h"
#else
/* Octaves share taps: the one that leaves the span of m is the middle one of 2 m. */
DAVAR_APART static void slide_octaves(allan_t *allan, const sample_t *head, const sample_t *tail)
{
    size_t span = 2U * (size_t)allan->m[0];
    tau_t *tau = allan->tau;
    const tau_t *const end = tau + allan->count;
    const difference_t newest = (difference_t)*head;
    const difference_t oldest = (difference_t)*tail;
    difference_t before = *(head - (span / 2U));
    difference_t behind = tail[span / 2U];
    for (; tau != end; tau++, span *= 2U) {
        const difference_t trailing = tau->tail;
        tau->tail = trailing + oldest - (2 * behind);
        behind = tail[span];
        tau->tail += behind;
        difference_t leading = tau->head + newest - (2 * before);
        before = *(head - span);
        leading += before;
        tau->head = leading;
        sum_slide(&tau->sum, leading, trailing);
    }
}
#endif

/* Both edges by one sample, with no gap near either and a window not shorter than the longest span. */
static inline void slide(allan_t *allan, const sample_t *head, const sample_t *tail)
{
    if (allan->octaves) {
        slide_octaves(allan, head, tail);
    } else {
        slide_any(allan, head, tail);
    }
}

#endif
