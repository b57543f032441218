/* davar - what a core without the instruction computes: too long to be inlined. */
#include "number/machine.h"

uint64_t davar_multiply_u32_by_parts(uint32_t a, uint32_t b)
{
    const uint32_t a0 = a & 0xFFFFU;
    const uint32_t a1 = a >> 16U;
    const uint32_t b0 = b & 0xFFFFU;
    const uint32_t b1 = b >> 16U;
    const uint32_t low = a0 * b0;
    const uint32_t middle = (a1 * b0) + (low >> 16U); /* at most (2^16 - 1) 2^16 */
    const uint32_t other = (a0 * b1) + (middle & 0xFFFFU);
    const uint32_t high = (a1 * b1) + (middle >> 16U) + (other >> 16U);
    return ((uint64_t)high << 32U) | (other << 16U) | (low & 0xFFFFU);
}

#if defined(DAVAR_NARROW_PRODUCT) && defined(__GNUC__) && !defined(DAVAR_PORTABLE)
uint64_t davar_multiply_u32_v6m(uint32_t a, uint32_t b)
{
    uint32_t low;
    uint32_t part;
    uint32_t other;
    __asm__(".syntax unified\n\t"
            "uxth   %[part], %[a]\n\t"       /* a0 */
            "lsrs   %[a], %[a], #16\n\t"     /* a1 */
            "lsrs   %[other], %[b], #16\n\t" /* b1 */
            "uxth   %[b], %[b]\n\t"          /* b0 */
            "movs   %[low], %[b]\n\t"
            "muls   %[low], %[part]\n\t"   /* a0 b0 */
            "muls   %[b], %[a]\n\t"        /* a1 b0 */
            "muls   %[a], %[other]\n\t"    /* a1 b1 */
            "muls   %[other], %[part]\n\t" /* a0 b1 */
            "lsls   %[part], %[b], #16\n\t"
            "lsrs   %[b], %[b], #16\n\t"
            "adds   %[low], %[part]\n\t"
            "adcs   %[a], %[b]\n\t"
            "lsls   %[part], %[other], #16\n\t"
            "lsrs   %[other], %[other], #16\n\t"
            "adds   %[low], %[part]\n\t"
            "adcs   %[a], %[other]"
            : [low] "=&l"(low), [part] "=&l"(part), [other] "=&l"(other), [a] "+l"(a), [b] "+l"(b)
            :
            : "cc");
    return ((uint64_t)a << 32U) | low;
}
#endif

#ifdef DAVAR_NARROW_PRODUCT
uint32_t davar_leading_zeros_32_shared(uint32_t value)
{
    return davar_leading_zeros_32_by_halving(value);
}
#endif
