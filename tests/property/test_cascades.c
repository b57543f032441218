#include "../fuzz/fuzz_cascades.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 1000U
#define RECORDED_DIGEST UINT64_C(0x3C2F6A074E2BE968)
#include "chains.h"
