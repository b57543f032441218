#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 600U
#define RECORDED_DIGEST UINT64_C(0x50883505E7C9B159)
#include "chains.h"
