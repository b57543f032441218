/* davar - the cascade: samples in, sums of squared differences at long cluster sizes (11.1) to
 * (11.5).
 *
 *   sample -> running sum -> hop of stage 0 -> served to one cluster size a sample -> hop of stage 1
 */
#include "davar/cascade.h"

#include "cascade/stage.h"
#include "number/quantum.h"
#include "number/real.h"
#include "number/sequence.h"

#include <string.h>

#define ACCEPTS_Q15 1U
#define ACCEPTS_Q31 2U
#define ACCEPTS_F32 3U

#define NARROW_TOP_BITS 16U /* of the running sums of q15, above the lower 32 */
#define WIDE_TOP_BITS 32U

#define SHORTEST_MIN 64U
#define SHORTEST_MAX 262140U /* hops of 65535 int16 samples sum to less than 2^31 */
#define CLUSTERS_MIN 4U
#define CLUSTERS_MAX 2048U /* a generation of 16 times as many differences is counted in 16 bits */

/* --- the work of a hop ------------------------------------------------------------------------ */

static inline bool is_wide(const davar_cascade_t *cascade)
{
    return DAVAR_Q31 && (!DAVAR_Q15 || (cascade->accepts != ACCEPTS_Q15));
}

static inline stage_t *stage_at(const davar_cascade_t *cascade, uint32_t k)
{
    return &((stage_t *)cascade->stages)[k];
}

/* The running sum at a hop of stage k: modulo 2^48 (q15) or 2^64. */
static inline uint64_t recall(const davar_cascade_t *cascade, uint32_t k, uint32_t hop)
{
    const uint32_t i = hop % CASCADE_HOPS;
    const uint32_t at = (k * CASCADE_HOPS) + i;
    const uint32_t top = is_wide(cascade) ? ((const uint32_t *)cascade->tops)[at]
                                          : ((const uint16_t *)cascade->tops)[at];
    return ((uint64_t)top << 32U) | stage_at(cascade, k)->low[i];
}

static inline void remember(davar_cascade_t *cascade, uint32_t k, uint32_t hop, uint64_t sum)
{
    const uint32_t i = hop % CASCADE_HOPS;
    const uint32_t at = (k * CASCADE_HOPS) + i;
    stage_at(cascade, k)->low[i] = (uint32_t)sum;
    if (is_wide(cascade)) {
        ((uint32_t *)cascade->tops)[at] = (uint32_t)(sum >> 32U);
    } else {
        ((uint16_t *)cascade->tops)[at] = (uint16_t)(sum >> 32U);
    }
}

/* |D| of the two clusters of `clusters` hops before the one that is served (11.1). */
static inline uint64_t difference(const davar_cascade_t *cascade, uint32_t k, uint32_t clusters)
{
    const stage_t *const stage = stage_at(cascade, k);
    const uint32_t unused = is_wide(cascade) ? 0U : (32U - NARROW_TOP_BITS);
    const uint64_t middle = recall(cascade, k, stage->hop - clusters);
    const uint64_t oldest = recall(cascade, k, stage->hop - (2U * clusters));
    const uint64_t d = (stage->pending - (2U * middle) + oldest) << unused;
    return (((d >> 63U) != 0U) ? (0U - d) : d) >> unused;
}

static inline davar_u128_t square(uint64_t a)
{
    if ((a >> 32U) == 0U) { /* most differences of noise */
        return (davar_u128_t){davar_multiply_u32((uint32_t)a, (uint32_t)a), 0U};
    }
    return davar_multiply_u64(a, a);
}

/* Serves the pending hop of stage k to one cluster size. The slot of that hop still holds the one
 * CASCADE_HOPS earlier, which the longest size needs. */
static inline void serve_tau(davar_cascade_t *cascade, uint32_t k, uint32_t turn)
{
    stage_t *const stage = stage_at(cascade, k);
    const uint32_t clusters = CASCADE_OVERLAP << turn;
    const uint32_t generation = clusters << cascade->shift;
    const uint32_t earlier = stage->hop - 1U; /* hops before it, from number 1 */
    const uint32_t now = ((earlier & generation) != 0U) ? 1U : 0U;
    davar_u128_t *const sum = &stage->tau[turn].squares[now];
    uint16_t *const count = &stage->count[turn][now];
    if ((earlier & (generation - 1U)) == 0U) {
        sum->low = 0U;
        sum->high = 0U;
        *count = 0U;
    }
    if (stage->age >= (2U * clusters)) {
        const davar_u128_t more = square(difference(cascade, k, clusters));
        davar_u128_t total;
        davar_u128_copy(&total, sum);
        total = davar_u128_add(total, more);
        davar_u128_copy(sum, &total);
        *count = (uint16_t)(*count + 1U);
    }
}

/* The stage is done with its hop. Each R-th is one of the next stage. */
static inline void pass_on(davar_cascade_t *cascade, uint32_t k)
{
    stage_t *const stage = stage_at(cascade, k);
    remember(cascade, k, stage->hop, stage->pending);
    stage->turn = 0U;
    cascade->ready = (uint8_t)(cascade->ready & ~(1U << k));
    if (((stage->hop % CASCADE_RATIO) == 0U) && ((k + 1U) < cascade->stage_count)) {
        stage_t *const next = stage_at(cascade, k + 1U);
        next->pending = stage->pending;
        next->age = stage->age / CASCADE_RATIO; /* both are rounded down */
        next->hop++;
        cascade->ready = (uint8_t)(cascade->ready | (2U << k));
    }
}

/* The first stage with a hop to serve is the one whose next hop is due first. */
static void serve(davar_cascade_t *cascade)
{
    uint32_t k = 0U;
    for (uint32_t ready = cascade->ready; (ready & 1U) == 0U; ready >>= 1U) {
        k++;
    }
    stage_t *const stage = stage_at(cascade, k);
    serve_tau(cascade, k, stage->turn);
    stage->turn++;
    if (stage->turn == CASCADE_TAUS) {
        pass_on(cascade, k);
    }
}

static uint32_t hop_of(const davar_cascade_t *cascade)
{
    return cascade->config->shortest / CASCADE_OVERLAP;
}

static void begin_hop(davar_cascade_t *cascade)
{
    stage_t *const first = stage_at(cascade, 0U);
    cascade->sum += (uint64_t)(int64_t)cascade->part;
    cascade->part = 0;
    cascade->hops++;
    cascade->left = hop_of(cascade);
    cascade->ready |= 1U;
    first->pending = cascade->sum;
    first->age = cascade->age;
    first->hop++;
    cascade->age += ((cascade->age >> 31U) == 0U) ? 1U : 0U;
}

/* A hop is due, or the previous one is not served yet. A hop has at least 16 samples, and all
 * stages together need 3 R / (R - 1) of them. */
DAVAR_APART static void event(davar_cascade_t *cascade)
{
    davar_sequence_begin(&cascade->sequence);
    cascade->left -= cascade->step;
    if (cascade->left == 0U) {
        begin_hop(cascade);
    } else {
        serve(cascade);
    }
    cascade->step = (cascade->ready != 0U) ? 1U : cascade->left;
    cascade->until = cascade->step;
    davar_sequence_end(&cascade->sequence);
}

/* --- samples in ------------------------------------------------------------------------------- */

static inline bool accepts(davar_cascade_t *cascade, uint8_t type, size_t count)
{
    const bool good = (cascade->accepts == type);
    DAVAR_ASSERT(good);
    if (!good) {
        davar_count_many(&cascade->health.missing, count);
    }
    return good;
}

void davar_cascade_push_q15(davar_cascade_t *cascade, const int16_t *counts, size_t count)
{
    if (!accepts(cascade, ACCEPTS_Q15, count)) {
        return;
    }
    for (size_t i = 0U; i < count; i++) {
        cascade->part += counts[i];
        cascade->until--;
        if (cascade->until == 0U) {
            event(cascade);
        }
    }
}

static inline void push_wide(davar_cascade_t *cascade, int32_t sample)
{
    cascade->sum += (uint64_t)(int64_t)sample;
    cascade->until--;
    if (cascade->until == 0U) {
        event(cascade);
    }
}

void davar_cascade_push_q31(davar_cascade_t *cascade, const int32_t *counts, size_t count)
{
    if (!accepts(cascade, ACCEPTS_Q31, count)) {
        return;
    }
    for (size_t i = 0U; i < count; i++) {
        push_wide(cascade, counts[i]);
    }
}

/* A gap before the next sample: the first hop without it is the newest one if no sample followed,
 * otherwise the next. */
static void mark_gap(davar_cascade_t *cascade)
{
    const uint32_t to_hop = cascade->left - (cascade->step - cascade->until);
    cascade->age = (to_hop == hop_of(cascade)) ? 1U : 0U;
    davar_count(&cascade->health.gaps);
}

DAVAR_RARE void davar_cascade_gap(davar_cascade_t *cascade, uint32_t missing)
{
    davar_count_many(&cascade->health.missing, missing);
    mark_gap(cascade);
}

/* A NaN or inf. A run of them is one gap. */
DAVAR_RARE static void drop(davar_cascade_t *cascade)
{
    davar_count(&cascade->health.not_finite);
    davar_count(&cascade->health.missing);
    if (!cascade->in_gap) {
        mark_gap(cascade);
    }
    cascade->in_gap = true;
}

void davar_cascade_push_f32(davar_cascade_t *cascade, const float *rates, size_t count)
{
    if (!accepts(cascade, ACCEPTS_F32, count)) {
        return;
    }
    const float limit = (float)cascade->config->full_scale;
    for (size_t i = 0U; i < count; i++) {
        if (!davar_is_finite(rates[i])) {
            drop(cascade);
            continue;
        }
        cascade->in_gap = false;
        if (davar_is_saturated(rates[i], limit)) {
            davar_count(&cascade->health.saturated);
        }
        push_wide(cascade, davar_float_to_counts(rates[i], limit, cascade->counts_per_unit));
    }
}

DAVAR_RARE void davar_cascade_flush(davar_cascade_t *cascade)
{
    while (cascade->ready != 0U) {
        serve(cascade);
    }
    const uint32_t to_hop = cascade->left - (cascade->step - cascade->until);
    cascade->left = to_hop;
    cascade->step = to_hop;
    cascade->until = to_hop;
}

/* --- start ------------------------------------------------------------------------------------ */

static bool is_wide_type(uint8_t type)
{
    return type != ACCEPTS_Q15;
}

static davar_status_t check_scale(const davar_cascade_config_t *config, uint8_t type)
{
    const bool is_float = (type == ACCEPTS_F32);
    if (!davar_is_between(1e-50, config->rate_hz, 1e50)) {
        return DAVAR_ERR_RATE;
    }
    const bool good = is_float ? davar_is_between(1e-20, config->full_scale, 1e20)
                               : davar_is_between(1e-50, config->unit_per_count, 1e50);
    return good ? DAVAR_OK : DAVAR_ERR_SCALE;
}

/* Do the sums hold (11.4)? */
static bool is_exact(const davar_cascade_config_t *config, uint8_t type)
{
    const uint64_t longest = (uint64_t)config->shortest << (config->tau_count - 1U);
    if (longest > (UINT64_C(1) << 31U)) {
        return false;
    }
    const uint32_t bits = (type == ACCEPTS_F32) ? DAVAR_FLOAT_BITS : 32U;
    const uint64_t room = (UINT64_C(1) << (123U - (2U * bits))) / config->clusters;
    return !is_wide_type(type) || ((longest * longest) <= room);
}

static davar_status_t check_clusters(const davar_cascade_config_t *config, uint8_t type)
{
    if ((config->shortest < SHORTEST_MIN) || (config->shortest > SHORTEST_MAX) ||
        ((config->shortest % CASCADE_OVERLAP) != 0U)) {
        return DAVAR_ERR_CASCADE_SHORTEST;
    }
    if ((config->clusters < CLUSTERS_MIN) || (config->clusters > CLUSTERS_MAX) ||
        ((config->clusters & (config->clusters - 1U)) != 0U)) {
        return DAVAR_ERR_CASCADE_CLUSTERS;
    }
    const bool good = (config->tau_count >= 1U) && (config->tau_count <= DAVAR_CASCADE_TAUS_MAX) &&
                      is_exact(config, type);
    return good ? DAVAR_OK : DAVAR_ERR_CASCADE_TAUS;
}

static uint32_t stages_for(const davar_cascade_config_t *config)
{
    return (config->tau_count + CASCADE_TAUS - 1U) / CASCADE_TAUS;
}

static size_t stage_bytes(uint8_t type)
{
    const uint32_t top_bits = is_wide_type(type) ? WIDE_TOP_BITS : NARROW_TOP_BITS;
    return sizeof(stage_t) + (CASCADE_HOPS * top_bits / 8U);
}

_Static_assert((sizeof(stage_t) + (2U * CASCADE_HOPS)) == DAVAR_CASCADE_STAGE_BYTES_Q15,
               "DAVAR_CASCADE_STAGE_BYTES_Q15");
_Static_assert((sizeof(stage_t) + (4U * CASCADE_HOPS)) == DAVAR_CASCADE_STAGE_BYTES_Q31,
               "DAVAR_CASCADE_STAGE_BYTES_Q31");

static davar_status_t check(const davar_cascade_t *cascade, const davar_cascade_config_t *config,
                            const void *memory, size_t bytes, uint8_t type)
{
    if ((cascade == NULL) || (config == NULL) || (memory == NULL)) {
        return DAVAR_ERR_NULL;
    }
    if (is_wide_type(type) ? !DAVAR_Q31 : !DAVAR_Q15) {
        return DAVAR_ERR_BUILD;
    }
    davar_status_t status = check_scale(config, type);
    if (status == DAVAR_OK) {
        status = check_clusters(config, type);
    }
    if ((status == DAVAR_OK) && (bytes < (stages_for(config) * stage_bytes(type)))) {
        status = DAVAR_ERR_MEMORY_SIZE;
    }
    if ((status == DAVAR_OK) && (((uintptr_t)memory % 8U) != 0U)) {
        status = DAVAR_ERR_MEMORY_ALIGN;
    }
    return status;
}

/* The start is hop 0 of every stage, with the running sum 0. */
DAVAR_RARE static void start(davar_cascade_t *cascade, const davar_cascade_config_t *config,
                             void *memory, uint8_t type)
{
    const uint32_t stages = stages_for(config);
    memset(cascade, 0, sizeof *cascade);
    memset(memory, 0, stages * stage_bytes(type));
    cascade->config = config;
    cascade->stages = memory;
    cascade->tops = &((stage_t *)memory)[stages];
    cascade->stage_count = (uint8_t)stages;
    cascade->accepts = type;
    cascade->age = 1U;
    for (uint32_t n = config->clusters; n > 1U; n >>= 1U) {
        cascade->shift++;
    }
    cascade->left = hop_of(cascade);
    cascade->step = cascade->left;
    cascade->until = cascade->left;
    if (type == ACCEPTS_F32) {
        cascade->counts_per_unit = davar_counts_per_unit(config->full_scale);
    }
}

DAVAR_RARE static davar_status_t init(davar_cascade_t *cascade,
                                      const davar_cascade_config_t *config, void *memory,
                                      size_t bytes, uint8_t type)
{
    const davar_status_t status = check(cascade, config, memory, bytes, type);
    if (status == DAVAR_OK) {
        start(cascade, config, memory, type);
    }
    return status;
}

davar_status_t davar_cascade_init_q15(davar_cascade_t *cascade,
                                      const davar_cascade_config_t *config, void *memory,
                                      size_t bytes)
{
    return init(cascade, config, memory, bytes, ACCEPTS_Q15);
}

davar_status_t davar_cascade_init_q31(davar_cascade_t *cascade,
                                      const davar_cascade_config_t *config, void *memory,
                                      size_t bytes)
{
    return init(cascade, config, memory, bytes, ACCEPTS_Q31);
}

davar_status_t davar_cascade_init_f32(davar_cascade_t *cascade,
                                      const davar_cascade_config_t *config, void *memory,
                                      size_t bytes)
{
    return init(cascade, config, memory, bytes, ACCEPTS_F32);
}

DAVAR_RARE void davar_cascade_reset(davar_cascade_t *cascade)
{
    start(cascade, cascade->config, cascade->stages, cascade->accepts);
}

davar_cascade_health_t davar_cascade_health(const davar_cascade_t *cascade)
{
    return cascade->health;
}
