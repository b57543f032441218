/* davar - the cascade: samples in; sums of squared differences at long cluster sizes, (11.1) to
 * (11.5), and of the power of the noise (11.9).
 *
 *   sample -> running sum -> hop of a stage -> a turn per sample -> hop of the next stage */
#include "davar/cascade.h"

#include "compact.h"
#include "number/machine.h"
#include "number/quantum.h"
#include "number/real.h"
#include "number/sequence.h"
#include "stage.h"

#include <string.h>

#define CASCADE_Q15 1U
#define CASCADE_Q31 2U
#define CASCADE_F32 3U

#define TOP_BITS_Q15 16U /* of the running sums of q15, above the lower 32 */
#define TOP_BITS_Q31 32U

#define SHORTEST_MIN 64U
#define SHORTEST_MAX 262140U /* hops of 65535 int16 samples sum to less than 2^31 */
#define CLUSTERS_MIN 4U
#define CLUSTERS_MAX 2048U /* a generation of 8 times as many differences is counted in 16 bits */

/* --- the work of a hop ------------------------------------------------------------------------ */

static inline bool is_wide_cascade(const davar_cascade_t *cascade)
{
    return DAVAR_Q31 && (!DAVAR_Q15 || (cascade->accepts != CASCADE_Q15));
}

static inline cascade_stage_t *stage_at(const davar_cascade_t *cascade, uint32_t k)
{
    return &((cascade_stage_t *)cascade->stages)[k];
}

/* The running sum at a hop of stage k: modulo 2^48 (q15) or 2^64. */
static inline uint64_t recall_hop(const davar_cascade_t *cascade, uint32_t k, uint32_t hop)
{
    const uint32_t i = hop % CASCADE_HOPS;
    const uint32_t at = (k * CASCADE_HOPS) + i;
    const uint32_t top = is_wide_cascade(cascade) ? ((const uint32_t *)cascade->tops)[at]
                                                  : ((const uint16_t *)cascade->tops)[at];
    return ((uint64_t)top << 32U) | stage_at(cascade, k)->low[i];
}

static inline void remember_hop(davar_cascade_t *cascade, uint32_t k, uint32_t hop, uint64_t sum)
{
    const uint32_t i = hop % CASCADE_HOPS;
    const uint32_t at = (k * CASCADE_HOPS) + i;
    stage_at(cascade, k)->low[i] = (uint32_t)sum;
    if (is_wide_cascade(cascade)) {
        ((uint32_t *)cascade->tops)[at] = (uint32_t)(sum >> 32U);
    } else {
        ((uint16_t *)cascade->tops)[at] = (uint16_t)(sum >> 32U);
    }
}

/* |D| of the two clusters of `clusters` hops before the one that is served (11.1). */
static inline uint64_t hop_difference(const davar_cascade_t *cascade, uint32_t k, uint32_t clusters)
{
    const cascade_stage_t *const stage = stage_at(cascade, k);
    const uint64_t middle = recall_hop(cascade, k, stage->hop - clusters);
    const uint64_t oldest = recall_hop(cascade, k, stage->hop - (2U * clusters));
    uint64_t d = stage->pending - (2U * middle) + oldest;
    if (!is_wide_cascade(cascade)) { /* the sign of 48 bits */
        const int32_t top = (int16_t)(uint16_t)(d >> 32U);
        d = ((uint64_t)(uint32_t)top << 32U) | (uint32_t)d;
    }
    return ((d >> 63U) != 0U) ? (0U - d) : d;
}

/* The rest of the square of 2^32 upper + lower. */
DAVAR_APART static void add_upper_square(davar_u128_t *sum, uint32_t lower, uint32_t upper)
{
    const uint64_t mixed = davar_multiply_u32(lower, upper); /* twice, 2^32 up */
    const davar_u128_t more = {mixed << 33U, davar_multiply_u32(upper, upper) + (mixed >> 31U)};
    *sum = davar_u128_add(*sum, more);
}

static inline void add_square(davar_u128_t *sum, uint64_t a)
{
    const uint32_t upper = (uint32_t)(a >> 32U);
    const uint64_t low = davar_multiply_u32((uint32_t)a, (uint32_t)a);
    sum->low += low;
    if (sum->low < low) {
        sum->high++;
    }
    if (upper != 0U) { /* few differences of noise */
        add_upper_square(sum, (uint32_t)a, upper);
    }
}

/* --- the power of the noise (11.9) --- */

/* Mean square of the shortest size over the cluster that ended. A cluster without differences,
 * because of a gap, repeats the one before. */
static inline void end_cluster(davar_cascade_t *cascade, cascade_stage_t *first, uint32_t slot)
{
    const uint32_t count = (uint32_t)first->count[slot] - cascade->seen_count;
    const davar_u128_t rest = cascade_unseen(cascade, &first->squares[slot]);
    const scaled_t sum = scaled_of_u128(&rest);
    cascade->seen[0] = first->squares[slot].low;
    cascade->seen[1] = first->squares[slot].high;
    cascade->seen_count = first->count[slot];
    if (count == CASCADE_CLUSTER) {
        cascade->power = compact_of_scaled((scaled_t){sum.mantissa, sum.exponent - 3});
    } else if (count > 0U) {
        cascade->power = compact_of_scaled(scaled_quotient(sum, scaled_of_u32(count, 0)));
    } else { /* as before */
    }
    first->cluster = cascade->power;
}

/* The cluster counts in the generation of a size. */
static inline void count_cluster(cascade_stage_t *stage, uint32_t slot)
{
    stage->power[slot] = compact_plus(stage->power[slot], stage->cluster);
    stage->power_squares[slot] =
        compact_plus(stage->power_squares[slot], compact_square(stage->cluster));
}

/* The cluster counts in the cluster of the next stage. */
static inline void pass_cluster_on(davar_cascade_t *cascade, cascade_stage_t *stage, uint32_t k)
{
    if ((k + 1U) < cascade->stage_count) {
        cascade_stage_t *const next = stage_at(cascade, k + 1U);
        next->cluster = compact_plus(next->cluster, stage->cluster);
    }
    stage->cluster = 0U;
}

/* A new generation takes the place of the one before the last. */
static inline void begin_generation(cascade_stage_t *stage, uint32_t slot)
{
    stage->squares[slot].low = 0U;
    stage->squares[slot].high = 0U;
    stage->count[slot] = 0U;
    stage->power[slot] = 0U;
    stage->power_squares[slot] = 0U;
}

/* Each second generation of the shorter size of a stage begins one of the longer size. */
static inline void begin_generations(davar_cascade_t *cascade, cascade_stage_t *stage, uint32_t k,
                                     uint32_t earlier)
{
    const uint32_t generation = CASCADE_OVERLAP << cascade->shift; /* of the shorter size */
    if ((earlier & (generation - 1U)) != 0U) {
        return;
    }
    begin_generation(stage, cascade_slot(cascade, 0U, earlier));
    if ((earlier & generation) == 0U) {
        begin_generation(stage, cascade_slot(cascade, 1U, earlier));
    }
    if (k == 0U) {
        cascade->seen[0] = 0U;
        cascade->seen[1] = 0U;
        cascade->seen_count = 0U;
    }
}

/* One of the turns after a cluster, whose last hop is the one before. */
DAVAR_APART static void after_cluster(davar_cascade_t *cascade, cascade_stage_t *stage, uint32_t k)
{
    const uint32_t earlier = stage->hop - 1U;
    uint32_t turn = stage->turn;
    if ((turn == (uint32_t)CASCADE_END) && (k > 0U)) { /* the stages before added it up */
        turn = (uint32_t)CASCADE_COUNT;
    }
    stage->turn = turn + 1U;
    if (turn == (uint32_t)CASCADE_END) {
        end_cluster(cascade, stage, cascade_slot(cascade, 0U, earlier - 1U));
    } else if (turn < (uint32_t)CASCADE_PASS) {
        const uint32_t size = turn - (uint32_t)CASCADE_COUNT;
        count_cluster(stage, cascade_slot(cascade, size, earlier - 1U));
    } else {
        pass_cluster_on(cascade, stage, k);
        begin_generations(cascade, stage, k, earlier);
    }
}

/* --- the turns of a hop --- */

/* Serves the pending hop of stage k to one cluster size. The slot of that hop still holds the one
 * CASCADE_HOPS earlier, which the longest size needs. */
static inline void serve_tau(davar_cascade_t *cascade, cascade_stage_t *stage, uint32_t k)
{
    const uint32_t size = stage->turn - (uint32_t)CASCADE_SERVE;
    const uint32_t clusters = CASCADE_OVERLAP << size;
    const uint32_t now = cascade_slot(cascade, size, stage->hop - 1U);
    if (stage->age >= (2U * clusters)) {
        stage->count[now]++;
        add_square(&stage->squares[now], hop_difference(cascade, k, clusters));
    }
}

/* The stage is done with its hop. Each R-th is one of the next stage. */
static inline void pass_on(davar_cascade_t *cascade, cascade_stage_t *stage, uint32_t k)
{
    remember_hop(cascade, k, stage->hop, stage->pending);
    stage->turn = 0U;
    cascade->ready = (uint16_t)(cascade->ready & ~(1U << k));
    if (((stage->hop % CASCADE_RATIO) == 0U) && ((k + 1U) < cascade->stage_count)) {
        cascade_stage_t *const next = stage_at(cascade, k + 1U);
        next->pending = stage->pending;
        next->age = stage->age / CASCADE_RATIO; /* both are rounded down */
        next->hop++;
        cascade->ready = (uint16_t)(cascade->ready | (2U << k));
    }
}

/* The first stage with a hop to serve is the one whose next hop is due first. */
static inline void serve_hop(davar_cascade_t *cascade)
{
    uint32_t k = 0U;
    for (uint32_t ready = cascade->ready; (ready & 1U) == 0U; ready >>= 1U) {
        k++;
    }
    cascade_stage_t *const stage = stage_at(cascade, k);
    if (stage->turn < (uint32_t)CASCADE_SERVE) {
        if (((stage->hop - 1U) % CASCADE_CLUSTER) == 0U) {
            after_cluster(cascade, stage, k);
            return;
        }
        stage->turn = (uint32_t)CASCADE_SERVE;
    }
    serve_tau(cascade, stage, k);
    stage->turn++;
    if (stage->turn == (uint32_t)CASCADE_DONE) {
        pass_on(cascade, stage, k);
    }
}

static uint32_t hop_of(const davar_cascade_t *cascade)
{
    return cascade->config->shortest / CASCADE_OVERLAP;
}

static void begin_hop(davar_cascade_t *cascade)
{
    cascade_stage_t *const first = stage_at(cascade, 0U);
    cascade->sum += (uint64_t)(int64_t)cascade->part;
    cascade->part = 0;
    cascade->left = hop_of(cascade);
    cascade->ready |= 1U;
    first->pending = cascade->sum;
    first->age = cascade->age;
    first->hop++;
    cascade->age += 1U - (cascade->age >> 31U);
}

/* A hop is due, or the previous one is not served yet. A hop has at least 16 samples, and all
 * stages together need at most 6 R / (R - 1) = 8 of them. */
DAVAR_APART static void cascade_event(davar_cascade_t *cascade)
{
    davar_sequence_begin(&cascade->sequence);
    cascade->left -= cascade->step;
    if (cascade->left == 0U) {
        begin_hop(cascade);
    } else {
        serve_hop(cascade);
    }
    cascade->step = (cascade->ready != 0U) ? 1U : cascade->left;
    cascade->until = cascade->step;
    davar_sequence_end(&cascade->sequence);
}

/* --- samples in ------------------------------------------------------------------------------- */

/* The caller has a bug: another type than that of init. */
DAVAR_APART DAVAR_RARE static void refuse_type(davar_cascade_t *cascade, size_t count)
{
    DAVAR_ASSERT(false);
    davar_count_many(&cascade->health.missing, count);
}

/* Samples of a block up to the next event, at least one. */
static inline size_t run_to_event(const davar_cascade_t *cascade, size_t left)
{
    return (left < cascade->until) ? left : cascade->until;
}

/* Samples are in the sum. */
static inline void advance_to_event(davar_cascade_t *cascade, size_t run)
{
    cascade->until -= (uint32_t)run;
    if (cascade->until == 0U) {
        cascade_event(cascade);
    }
}

/* Blocks, apart, so that a push of one sample needs no stack. */
DAVAR_APART static void push_narrow_block(davar_cascade_t *cascade, const int16_t *counts,
                                          size_t count)
{
    for (size_t taken = 0U; taken < count;) {
        const size_t run = run_to_event(cascade, count - taken);
        DAVAR_ASSERT((run > 0U) && (run <= (count - taken)));
        int32_t part = cascade->part;
        for (size_t i = taken; i < (taken + run); i++) {
            part += counts[i];
        }
        cascade->part = part;
        taken += run;
        advance_to_event(cascade, run);
    }
}

DAVAR_APART static void push_wide_block(davar_cascade_t *cascade, const int32_t *counts,
                                        size_t count)
{
    for (size_t taken = 0U; taken < count;) {
        const size_t run = run_to_event(cascade, count - taken);
        DAVAR_ASSERT((run > 0U) && (run <= (count - taken)));
        uint64_t sum = cascade->sum;
        for (size_t i = taken; i < (taken + run); i++) {
            sum += (uint64_t)(int64_t)counts[i];
        }
        cascade->sum = sum;
        taken += run;
        advance_to_event(cascade, run);
    }
}

void davar_cascade_push_q15(davar_cascade_t *cascade, const int16_t *counts, size_t count)
{
    if (cascade->accepts != CASCADE_Q15) {
        refuse_type(cascade, count);
    } else if (count == 1U) {
        cascade->part += *counts;
        advance_to_event(cascade, 1U);
    } else {
        push_narrow_block(cascade, counts, count);
    }
}

void davar_cascade_push_q31(davar_cascade_t *cascade, const int32_t *counts, size_t count)
{
    if (cascade->accepts != CASCADE_Q31) {
        refuse_type(cascade, count);
    } else if (count == 1U) {
        cascade->sum += (uint64_t)(int64_t)*counts;
        advance_to_event(cascade, 1U);
    } else {
        push_wide_block(cascade, counts, count);
    }
}

/* A gap before the next sample: the first hop without it is the newest one if no sample followed,
 * otherwise the next. */
static void mark_hop_gap(davar_cascade_t *cascade)
{
    const uint32_t to_hop = cascade->left - (cascade->step - cascade->until);
    cascade->age = (to_hop == hop_of(cascade)) ? 1U : 0U;
    davar_count(&cascade->health.gaps);
}

DAVAR_RARE void davar_cascade_gap(davar_cascade_t *cascade, uint32_t missing)
{
    davar_count_many(&cascade->health.missing, missing);
    mark_hop_gap(cascade);
}

/* A NaN or inf. A run of them is one gap. */
DAVAR_RARE static void drop_sample(davar_cascade_t *cascade)
{
    davar_count(&cascade->health.not_finite);
    davar_count(&cascade->health.missing);
    if (!cascade->in_gap) {
        mark_hop_gap(cascade);
    }
    cascade->in_gap = true;
}

void davar_cascade_push_f32(davar_cascade_t *cascade, const float *rates, size_t count)
{
    if (cascade->accepts != CASCADE_F32) {
        refuse_type(cascade, count);
        return;
    }
    const float limit = cascade->limit;
    for (size_t i = 0U; i < count; i++) {
        if (!davar_is_finite(rates[i])) {
            drop_sample(cascade);
            continue;
        }
        cascade->in_gap = false;
        const int32_t sample = davar_float_to_counts(rates[i], limit, cascade->counts_per_unit,
                                                     &cascade->health.saturated);
        cascade->sum += (uint64_t)(int64_t)sample;
        advance_to_event(cascade, 1U);
    }
}

DAVAR_RARE void davar_cascade_flush(davar_cascade_t *cascade)
{
    const uint32_t to_hop = cascade->left - (cascade->step - cascade->until);
    while (cascade->ready != 0U) {
        cascade->left = to_hop;
        cascade->step = 0U;
        cascade_event(cascade);
    }
}

/* --- start ------------------------------------------------------------------------------------ */

static bool is_wide_type(uint8_t type)
{
    return type != CASCADE_Q15;
}

static davar_cascade_status_t check_cascade_scale(const davar_cascade_config_t *config,
                                                  uint8_t type)
{
    const bool is_float = (type == CASCADE_F32);
    if (!davar_is_between(1e-50, config->rate_hz, 1e50)) {
        return DAVAR_CASCADE_ERR_RATE;
    }
    const bool good = is_float ? davar_is_between(1e-20, config->full_scale, 1e20)
                               : davar_is_between(1e-50, config->unit_per_count, 1e50);
    return good ? DAVAR_CASCADE_OK : DAVAR_CASCADE_ERR_SCALE;
}

/* Do the sums hold (11.4)? */
static bool is_cascade_exact(const davar_cascade_config_t *config, uint8_t type)
{
    const uint64_t longest = (uint64_t)config->shortest << (config->tau_count - 1U);
    if (longest > (UINT64_C(1) << 31U)) {
        return false;
    }
    const uint32_t bits = (type == CASCADE_F32) ? DAVAR_FLOAT_BITS : 32U;
    const uint64_t room = (UINT64_C(1) << (124U - (2U * bits))) / config->clusters;
    return !is_wide_type(type) || ((longest * longest) <= room);
}

static davar_cascade_status_t check_cascade_clusters(const davar_cascade_config_t *config,
                                                     uint8_t type)
{
    if ((config->shortest < SHORTEST_MIN) || (config->shortest > SHORTEST_MAX) ||
        ((config->shortest % CASCADE_OVERLAP) != 0U)) {
        return DAVAR_CASCADE_ERR_SHORTEST;
    }
    if ((config->clusters < CLUSTERS_MIN) || (config->clusters > CLUSTERS_MAX) ||
        ((config->clusters & (config->clusters - 1U)) != 0U)) {
        return DAVAR_CASCADE_ERR_CLUSTERS;
    }
    const bool good = (config->tau_count >= 1U) && (config->tau_count <= DAVAR_CASCADE_TAUS_MAX) &&
                      is_cascade_exact(config, type);
    return good ? DAVAR_CASCADE_OK : DAVAR_CASCADE_ERR_TAUS;
}

static uint32_t stages_for(const davar_cascade_config_t *config)
{
    return (config->tau_count + CASCADE_TAUS - 1U) / CASCADE_TAUS;
}

static size_t cascade_stage_bytes(uint8_t type)
{
    const uint32_t top_bits = is_wide_type(type) ? TOP_BITS_Q31 : TOP_BITS_Q15;
    return sizeof(cascade_stage_t) + (CASCADE_HOPS * top_bits / 8U);
}

_Static_assert((sizeof(cascade_stage_t) + ((size_t)2U * CASCADE_HOPS)) ==
                   DAVAR_CASCADE_STAGE_BYTES_Q15,
               "DAVAR_CASCADE_STAGE_BYTES_Q15");
_Static_assert((sizeof(cascade_stage_t) + ((size_t)4U * CASCADE_HOPS)) ==
                   DAVAR_CASCADE_STAGE_BYTES_Q31,
               "DAVAR_CASCADE_STAGE_BYTES_Q31");

static davar_cascade_status_t check_cascade_memory(const davar_cascade_config_t *config,
                                                   const void *memory, size_t bytes, uint8_t type)
{
    if (bytes < (stages_for(config) * cascade_stage_bytes(type))) {
        return DAVAR_CASCADE_ERR_MEMORY_SIZE;
    }
    return (((uintptr_t)memory % 8U) != 0U) ? DAVAR_CASCADE_ERR_MEMORY_ALIGN : DAVAR_CASCADE_OK;
}

static davar_cascade_status_t check_cascade(const davar_cascade_t *cascade,
                                            const davar_cascade_config_t *config,
                                            const void *memory, size_t bytes, uint8_t type)
{
    if ((cascade == NULL) || (config == NULL) || (memory == NULL)) {
        return DAVAR_CASCADE_ERR_NULL;
    }
    davar_cascade_status_t status = check_cascade_scale(config, type);
    if (status == DAVAR_CASCADE_OK) {
        status = check_cascade_clusters(config, type);
    }
    return (status == DAVAR_CASCADE_OK) ? check_cascade_memory(config, memory, bytes, type)
                                        : status;
}

/* The start is hop 0 of every stage, with the running sum 0. */
DAVAR_RARE static void cascade_start(davar_cascade_t *cascade, const davar_cascade_config_t *config,
                                     void *memory, uint8_t type)
{
    const uint32_t stages = stages_for(config);
    memset(cascade, 0, sizeof *cascade);
    memset(memory, 0, stages * cascade_stage_bytes(type));
    cascade->config = config;
    cascade->stages = memory;
    cascade->tops = &((cascade_stage_t *)memory)[stages];
    cascade->memory_bytes = (uint32_t)(stages * cascade_stage_bytes(type));
    cascade->stage_count = (uint8_t)stages;
    cascade->accepts = type;
    cascade->age = 1U;
    for (uint32_t n = config->clusters; n > 1U; n >>= 1U) {
        cascade->shift++;
    }
    cascade->left = hop_of(cascade);
    cascade->step = cascade->left;
    cascade->until = cascade->left;
    if (type == CASCADE_F32) {
        cascade->limit = (float)config->full_scale;
        cascade->counts_per_unit = davar_counts_per_unit(config->full_scale);
    }
}

DAVAR_RARE static davar_cascade_status_t cascade_init(davar_cascade_t *cascade,
                                                      const davar_cascade_config_t *config,
                                                      void *memory, size_t bytes, uint8_t type)
{
    const davar_cascade_status_t status = check_cascade(cascade, config, memory, bytes, type);
    if (status == DAVAR_CASCADE_OK) {
        cascade_start(cascade, config, memory, type);
    }
    return status;
}

davar_cascade_status_t davar_cascade_init_q15(davar_cascade_t *cascade,
                                              const davar_cascade_config_t *config, void *memory,
                                              size_t bytes)
{
    return DAVAR_Q15 ? cascade_init(cascade, config, memory, bytes, CASCADE_Q15)
                     : DAVAR_CASCADE_ERR_BUILD;
}

davar_cascade_status_t davar_cascade_init_q31(davar_cascade_t *cascade,
                                              const davar_cascade_config_t *config, void *memory,
                                              size_t bytes)
{
    return DAVAR_Q31 ? cascade_init(cascade, config, memory, bytes, CASCADE_Q31)
                     : DAVAR_CASCADE_ERR_BUILD;
}

davar_cascade_status_t davar_cascade_init_f32(davar_cascade_t *cascade,
                                              const davar_cascade_config_t *config, void *memory,
                                              size_t bytes)
{
    return DAVAR_Q31 ? cascade_init(cascade, config, memory, bytes, CASCADE_F32)
                     : DAVAR_CASCADE_ERR_BUILD;
}

DAVAR_RARE void davar_cascade_reset(davar_cascade_t *cascade)
{
    cascade_start(cascade, cascade->config, cascade->stages, cascade->accepts);
}

davar_cascade_health_t davar_cascade_health(const davar_cascade_t *cascade)
{
    return cascade->health;
}

/* --- the reasons as text ---------------------------------------------------------------------- */

const char *davar_cascade_status_text(davar_cascade_status_t status)
{
    static const char *const text[] = {
        [DAVAR_CASCADE_OK] = "ok",
        [DAVAR_CASCADE_ERR_NULL] = "a pointer is null",
        [DAVAR_CASCADE_ERR_BUILD] = "disabled in this build",
        [DAVAR_CASCADE_ERR_RATE] = "sample rate not a positive number",
        [DAVAR_CASCADE_ERR_SCALE] =
            "size of a count, or full scale, not a positive number in range",
        [DAVAR_CASCADE_ERR_SHORTEST] =
            "shortest cluster size not a multiple of 4 from 64 to 262140 samples",
        [DAVAR_CASCADE_ERR_CLUSTERS] = "remembered clusters not a power of two from 4 to 2048",
        [DAVAR_CASCADE_ERR_TAUS] =
            "no cluster size, too many, or the longest too long for the exact sums",
        [DAVAR_CASCADE_ERR_MEMORY_SIZE] = "memory too small",
        [DAVAR_CASCADE_ERR_MEMORY_ALIGN] = "memory not aligned to 8 bytes",
    };
    return ((size_t)status < (sizeof text / sizeof text[0])) ? text[status] : "unknown status";
}
