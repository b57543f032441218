#include "../fuzz/fuzz_selections.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 5000U
#define RECORDED_DIGEST UINT64_C(0x1C2C8851C98C376C)
#include "chains.h"
