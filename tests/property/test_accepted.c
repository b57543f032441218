#include "../fuzz/fuzz_tracked.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 500U
#define RECORDED_DIGEST UINT64_C(0x16E2613C0075A207)
#include "chains.h"
