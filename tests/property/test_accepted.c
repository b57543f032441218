#include "../fuzz/fuzz_tracked.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 500U
#define RECORDED_DIGEST UINT64_C(0x297348FF85978E57)
#include "chains.h"
