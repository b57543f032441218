#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 1000U
#define RECORDED_DIGEST UINT64_C(0xCB129A9017B171AF)
#include "chains.h"
