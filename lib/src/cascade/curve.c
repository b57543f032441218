/* davar - the cascade: sums out, as cluster sizes of a result (11.1), and how strong the noise was
 * that each remembers (11.9). */
#include "cascade/stage.h"
#include "davar/cascade.h"
#include "number/absent.h"
#include "number/ieee.h"
#include "number/real.h"
#include "number/sequence.h"

#include <math.h>

#define UNEVEN_BITS 8U
_Static_assert(DAVAR_EVEN == (1U << UNEVEN_BITS), "the unit of davar_adev_t.uneven");

/* One size, its two generations as they are at one sample: [0] the present one. */
typedef struct {
    davar_u128_t squares[2];
    uint32_t count[2];
    compact_t power[2];
    compact_t power_squares[2];
    uint32_t generation; /* number of the present one */
    uint32_t shorter;    /* ... of the size before this one */
    uint32_t hops;       /* of the present one so far */
} memory_t;

/* Power of the samples: its sum over the generations of the shortest size, the sum of its squares,
 * and their length in hops of that size. */
typedef struct {
    scaled_t sum;
    scaled_t squares;
    uint64_t hops;
} power_t;

/* Powers of all sizes up to the one that is read. */
typedef struct {
    power_t present;                       /* of the size before, its present generation */
    uint32_t generation;                   /* and the number of that */
    compact_t sum[DAVAR_CASCADE_TAUS_MAX]; /* of each size, its present generation */
} powers_t;

static void copy_memory(const davar_cascade_t *cascade, uint32_t t, memory_t *memory)
{
    const cascade_stage_t *const stage = cascade_stage_of(cascade, t);
    const uint32_t mask = (1U << cascade_generation_bits(cascade, t)) - 1U;
    memory->generation = cascade_generation(cascade, t);
    memory->shorter = (t > 0U) ? cascade_generation(cascade, t - 1U) : 0U;
    memory->hops = ((cascade_newest_hop(cascade, t) - 1U) & mask) + 1U;
    for (uint32_t i = 0U; i < 2U; i++) {
        const uint32_t slot = cascade_present(cascade, t) ^ i;
        davar_u128_copy(&memory->squares[i], &stage->squares[slot]);
        memory->count[i] = stage->count[slot];
        memory->power[i] = stage->power[slot];
        memory->power_squares[i] = stage->power_squares[slot];
    }
}

/* Hazard: a push may come between. */
static void read_memory(const davar_cascade_t *cascade, uint32_t t, memory_t *memory)
{
    uint32_t before;
    do {
        before = davar_sequence_read(&cascade->sequence);
        copy_memory(cascade, t, memory);
    } while (davar_sequence_torn(&cascade->sequence, before));
}

/* (1.1) with the differences of (11.1) */
static double deviation_of_hops(const davar_u128_t *sum, const davar_adev_t *tau)
{
    const double m = davar_double_of_u64(tau->m);
    const double divisor =
        davar_scale(davar_scale(m, m), davar_double_of_u64(2U * (uint64_t)tau->differences));
    return davar_root_of_quotient(davar_double_of_u128(*sum), divisor);
}

/* --- the power of the samples (11.9) --- */

static void add_power(power_t *power, scaled_t sum, scaled_t squares, uint64_t hops)
{
    power->sum = davar_scaled_plus(power->sum, sum);
    power->squares = davar_scaled_plus(power->squares, squares);
    power->hops += hops;
}

static scaled_t ratio(scaled_t a, scaled_t b)
{
    return scaled_times(a, scaled_inverse(b));
}

/* The shortest size: its present generation has no sum of powers yet. */
static power_t shortest_power(const davar_cascade_t *cascade, const memory_t *memory)
{
    power_t power = {{0U, SCALED_ZERO}, {0U, SCALED_ZERO}, 0U};
    if (memory->count[0] > 0U) {
        const scaled_t mean =
            ratio(scaled_of_u128(&memory->squares[0]), scaled_of_u32(memory->count[0], 0));
        const scaled_t part =
            scaled_of_u32(memory->hops, -(int32_t)cascade_generation_bits(cascade, 0U));
        add_power(&power, scaled_times(mean, part), scaled_times(scaled_times(mean, mean), part),
                  memory->hops);
    }
    return power;
}

/* The present generation of size t: those of the size before that ended in it, and the present one
 * of that, unless it began since it was read. */
static power_t present_power(const davar_cascade_t *cascade, const memory_t *memory,
                             const powers_t *before, uint32_t t)
{
    power_t power = {{0U, SCALED_ZERO}, {0U, SCALED_ZERO}, 0U};
    const uint32_t ended = (memory->shorter - (2U * memory->generation)) & 3U;
    const uint32_t bits = cascade_generation_bits(cascade, 0U);
    add_power(&power, scaled_of_compact(memory->power[0]),
              scaled_of_compact(memory->power_squares[0]), (uint64_t)ended << (t - 1U + bits));
    if (memory->shorter == before->generation) {
        const bool wide = t > cascade->shift;
        const scaled_t sum =
            wide ? scaled_of_compact(before->sum[t - cascade->shift]) : before->present.sum;
        add_power(&power, before->present.sum,
                  wide ? scaled_times(sum, sum) : before->present.squares, before->present.hops);
    }
    return power;
}

/* Writes the mean power of what size t remembers, 0 if it is unknown, and how unevenly it is spread. */
static void take_power(const davar_cascade_t *cascade, const memory_t *memory, powers_t *before,
                       uint32_t t, davar_adev_t *tau)
{
    const uint32_t bits = cascade_generation_bits(cascade, 0U);
    const int32_t wide = (t > cascade->shift) ? (int32_t)(t - cascade->shift) : 0;
    power_t power =
        (t == 0U) ? shortest_power(cascade, memory) : present_power(cascade, memory, before, t);
    before->present = power;
    before->generation = memory->generation;
    before->sum[t] = compact_of_scaled(power.sum);
    if (memory->count[1] > 0U) {
        add_power(&power, scaled_of_compact(memory->power[1]),
                  scaled_of_compact(memory->power_squares[1]), UINT64_C(1) << (t + bits));
    }
    tau->power = 0.0F;
    tau->uneven = DAVAR_EVEN;
    if ((power.sum.mantissa > 0U) && (power.hops > 0U)) {
        const scaled_t mean = ratio(power.sum, scaled_of_u64(power.hops, -(int32_t)bits));
        const scaled_t spread = ratio(ratio(power.squares, power.sum), mean);
        const uint32_t uneven = davar_scaled_to_fixed(spread, (int32_t)UNEVEN_BITS - wide);
        tau->power = scaled_to_float(mean);
        tau->uneven = (uint16_t)((uneven < UINT16_MAX) ? uneven : UINT16_MAX);
    }
    if (tau->uneven < DAVAR_EVEN) {
        tau->uneven = DAVAR_EVEN;
    }
}

/* Powers become ratios to that of the longest size, which is a mean over the longest time. */
static void relate_powers(davar_result_t *result, uint32_t first)
{
    float longest = 0.0F;
    for (uint32_t t = first; t < result->tau_count; t++) {
        longest = (result->tau[t].differences > 0U) ? result->tau[t].power : longest;
    }
    for (uint32_t t = first; t < result->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        const bool known = (tau->power > 0.0F) && (longest > 0.0F);
        tau->power =
            known ? scaled_to_float(ratio(scaled_of_float(tau->power), scaled_of_float(longest)))
                  : 1.0F;
    }
}

static void take_cascade_tau(const davar_cascade_t *cascade, uint32_t t, double unit,
                             powers_t *powers, davar_adev_t *tau)
{
    memory_t memory;
    read_memory(cascade, t, &memory);
    const davar_u128_t squares = davar_u128_add(memory.squares[0], memory.squares[1]);
    tau->m = cascade->config->shortest << t;
    tau->hops = (uint8_t)(CASCADE_OVERLAP << (t % CASCADE_TAUS));
    tau->differences = memory.count[0] + memory.count[1];
    tau->adev =
        (tau->differences > 0U) ? davar_scale(deviation_of_hops(&squares, tau), unit) : (double)NAN;
    take_power(cascade, &memory, powers, t, tau);
}

bool davar_cascade_append(const davar_cascade_t *cascade, davar_result_t *result)
{
    const davar_cascade_config_t *const config = cascade->config;
    const bool is_float = (cascade->counts_per_unit > 0.0F);
    const double unit =
        is_float ? davar_inverse_of_power(cascade->counts_per_unit) : config->unit_per_count;
    const uint32_t first = result->tau_count;
    powers_t powers = {0};
    bool any = false;
    DAVAR_ASSERT((first + config->tau_count) <= (uint32_t)DAVAR_TAUS_MAX);
    DAVAR_ASSERT((first == 0U) || (result->tau[first - 1U].m < config->shortest));
    result->unit_per_count = is_float ? 0.0 : unit;
    for (uint32_t t = 0U; t < config->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[first + t];
        take_cascade_tau(cascade, t, unit, &powers, tau);
        any = any || (tau->differences > 0U);
        result->tau_count++;
    }
    relate_powers(result, first);
    davar_absent_taus(result, first);
    return any;
}
