/* davar - the logarithm in integers: a table of 32 intervals, and three terms of the series in
 * each. */
#include "laws/logarithm.h"

#define LN_2_Q24 11629080 /* relative error 1e-9 */

/* ln(1 + i / 32), 31 binary digits */
static const uint32_t ln_of_edge[32] = {
    0x00000000U, 0x03F05362U, 0x07C28C30U, 0x0B786945U, 0x0F1383B7U, 0x129552F8U, 0x15FF3071U,
    0x19525A9DU, 0x1C8FF7C8U, 0x1FB9186DU, 0x22CEB957U, 0x25D1C576U, 0x28C31784U, 0x2BA37B7FU,
    0x2E73AFEDU, 0x3134670EU, 0x33E647D9U, 0x3689EEF8U, 0x391FEF8FU, 0x3BA8D40AU, 0x3E251EBFU,
    0x40954A97U, 0x42F9CB91U, 0x45530F4CU, 0x47A17D7AU, 0x49E5784AU, 0x4C1F5CCDU, 0x4E4F834DU,
    0x50763FA1U, 0x5293E177U, 0x54A8B499U, 0x56B50131U,
};

/* 1 / (1 + i / 32), 31 binary digits */
static const uint32_t inverse_of_edge[32] = {
    0x80000000U, 0x7C1F07C2U, 0x78787878U, 0x75075075U, 0x71C71C72U, 0x6EB3E453U, 0x6BCA1AF3U,
    0x69069069U, 0x66666666U, 0x63E7063EU, 0x61861862U, 0x5F417D06U, 0x5D1745D1U, 0x5B05B05BU,
    0x590B2164U, 0x572620AEU, 0x55555555U, 0x5397829DU, 0x51EB851FU, 0x50505050U, 0x4EC4EC4FU,
    0x4D4873EDU, 0x4BDA12F7U, 0x4A7904A8U, 0x49249249U, 0x47DC11F7U, 0x469EE584U, 0x456C797EU,
    0x44444444U, 0x4325C53FU, 0x42108421U, 0x41041041U,
};

int32_t davar_logarithm(uint32_t mantissa, int32_t exponent)
{
    const uint32_t i = (mantissa >> 26U) & 31U;
    const uint32_t beyond = (mantissa & 0x3FFFFFFU) << 5U;              /* 0 .. 1/32, 36 digits */
    const uint32_t x = davar_upper_product(beyond, inverse_of_edge[i]); /* 35 digits */
    const uint32_t square = davar_upper_product(x, x);                  /* 38 digits */
    const uint32_t cube = davar_upper_product(square, x);               /* 41 digits */
    /* ln(1 + x) = x - x^2/2 + 83/256 x^3, 31 digits */
    const uint32_t rest = (x >> 4U) - (square >> 8U) + (((cube >> 10U) * 83U) >> 8U);
    return (int32_t)((ln_of_edge[i] + rest) >> 7U) + ((exponent + 31) * LN_2_Q24);
}
