#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 4000U
#define RECORDED_DIGEST UINT64_C(0xC4F0B9B78DC7528D)
#include "chains.h"
