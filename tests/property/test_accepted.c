#include "../fuzz/fuzz_tracked.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 500U
#define RECORDED_DIGEST UINT64_C(0xA576CD6F5D7F38D0)
#include "chains.h"
