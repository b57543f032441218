#include "../fuzz/fuzz_tracked.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 500U
#define RECORDED_DIGEST UINT64_C(0xD5AD0ADFAC61CFA7)
#include "chains.h"
