#include "../fuzz/fuzz_cascades.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 2000U
#define RECORDED_DIGEST UINT64_C(0x2343FB24D9382327)
#include "chains.h"
