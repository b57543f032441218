#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 600U
#define RECORDED_DIGEST UINT64_C(0x95F2E9545CFE0DE5)
#include "chains.h"
