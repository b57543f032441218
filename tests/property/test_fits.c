#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 600U
#define RECORDED_DIGEST UINT64_C(0x818D8FBBAA93F85F)
#include "chains.h"
