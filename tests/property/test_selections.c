#include "../fuzz/fuzz_selections.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 1000U
#define RECORDED_DIGEST UINT64_C(0x5C6693C522B44FEA)
#include "chains.h"
