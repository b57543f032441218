/* Statement: for any arguments that its comments allow, no arithmetic of lib/src/number overflows a
 * signed type, shifts by its width or more, or reads outside a table. Products are by parts, as on
 * a Cortex-M0, and doubles in integers, as on cores without a double unit. No bound: the complete
 * range of each argument, split into pieces where the code tests its size. */
#include "laws/logarithm.h"
#include "number/scaled.h"

#include "proof.h"

static float any_float_of(uint32_t low, uint32_t high)
{
    return davar_float_of_bits(any_u32(low, high));
}

static double any_double_of(uint64_t low, uint64_t high)
{
    return davar_double_of_bits(Frama_C_unsigned_long_long_interval(low, high));
}

static volatile uint64_t sink;

static void products(int32_t a, int32_t b)
{
    sink = davar_multiply_i32_by_parts(a, b);
    sink = davar_multiply_i32(a, b);
}

static void prove_machine(void)
{
    /* Pieces: fits 16 bits, or not. */
    static const int32_t low[3] = {INT32_MIN, INT16_MIN, INT16_MAX + 1};
    static const int32_t high[3] = {INT16_MIN - 1, INT16_MAX, INT32_MAX};
    for (unsigned i = 0U; i < 3U; i++) {
        const int32_t a = any_i32(low[i], high[i]);
        sink = davar_square_i32_by_parts(a);
        sink = davar_square_i32(a);
        sink = davar_size_i32(a);
        for (unsigned k = 0U; k < 3U; k++) {
            products(a, any_i32(low[k], high[k]));
        }
    }
    const int16_t small = (int16_t)any_i32(INT16_MIN, INT16_MAX);
    sink = davar_square_i16(small);
    sink = davar_multiply_by_i16(any_i32(0, INT32_MAX), small);
    sink = davar_multiply_by_i16_by_parts(any_i32(0, INT32_MAX), small);
    const davar_u128_t a = {any_u64(), any_u64()};
    const davar_u128_t b = {any_u64(), any_u64()};
    davar_u128_t c = davar_u128_add(a, b);
    c = davar_u128_subtract(c, b);
    c = davar_u128_scale(c, any_u32(0U, UINT32_MAX));
    sink = c.low ^ c.high;
    c = davar_multiply_u64_by_parts(any_u64(), any_u64());
    sink = c.low ^ c.high;
    c = davar_multiply_i64((int64_t)any_u64(), (int64_t)any_u64());
    sink = c.low ^ c.high;
    sink = davar_scale_u64(any_u64(), any_u32(0U, UINT32_MAX));
    sink = davar_multiply_u32_by_parts(any_u32(0U, UINT32_MAX), any_u32(0U, UINT32_MAX));
}

static void prove_zeros(void)
{
    for (unsigned bit = 0U; bit < 32U; bit++) { /* by the highest bit that is set */
        const uint32_t least = UINT32_C(1) << bit;
        const uint32_t value = any_u32(least, least + (least - 1U));
        const uint32_t zeros = davar_leading_zeros_32_by_halving(value);
        PROVE(zeros <= 31U);
        sink = davar_logarithm(value << (31U - bit), any_i32(-64, 64));
        sink = davar_divided(any_u32(0U, UINT32_MAX), value);
    }
}

static void prove_real(void)
{
    sink = davar_root_of_mantissa_by_integers(any_u32(UINT32_C(1) << 30U, UINT32_MAX));
    sink = davar_reciprocal_of_mantissa(any_u32(UINT32_C(1) << 31U, UINT32_MAX));
    for (unsigned bit = 0U; bit < 64U;
         bit++) { /* by the highest bit that is set: an exponent's, or a subnormal's */
        const uint64_t least = UINT64_C(1) << bit;
        const uint64_t bits = Frama_C_unsigned_long_long_interval(least, least + (least - 1U));
        sink = davar_bits_of_double(davar_root_by_integers(davar_double_of_bits(bits)));
        sink = davar_bits_of_double(davar_double_of_u64_by_parts(bits));
    }
    sink = davar_bits_of_double(davar_root_by_integers(0.0));
    sink = davar_bits_of_double(davar_double_of_u64_by_parts(0U));
    sink = davar_bits_of_double(
        davar_divide_by_integers(any_double_of(0U, UINT64_MAX), any_double_of(0U, UINT64_MAX)));
    sink = davar_bits_of_double(
        davar_scale_by_integers(any_double_of(0U, UINT64_MAX), any_double_of(0U, UINT64_MAX)));
    sink = davar_bits_of_double(davar_root_of_quotient_by_integers(any_double_of(0U, UINT64_MAX),
                                                                   any_double_of(0U, UINT64_MAX)));
}

/* Exponents of three doubles' product at most. */
static void prove_scaled(void)
{
    const scaled_t a = {any_u32(SCALED_TOP, UINT32_MAX), any_i32(SCALED_ZERO, -SCALED_ZERO)};
    const scaled_t b = {any_u32(SCALED_TOP, UINT32_MAX), any_i32(SCALED_ZERO, -SCALED_ZERO)};
    sink = scaled_times(a, b).mantissa;
    sink = davar_root_of_mantissa_by_integers((a.mantissa & ~UINT32_C(0xFF)) >> 1U);
    sink = scaled_inverse(a).mantissa;
    sink = davar_scaled_plus(a, b).mantissa;
    sink = davar_scaled_to_fixed(a, any_i32(0, 31));
    sink = davar_bits_of_double(davar_scaled_to_double(a));
    sink = scaled_of_double(any_double_of(0U, UINT64_MAX)).mantissa;
    sink = scaled_of_float(any_float_of(0U, UINT32_MAX)).mantissa;
}

void prove(void)
{
    prove_machine();
    prove_zeros();
    prove_real();
    prove_scaled();
    PROVED();
}
