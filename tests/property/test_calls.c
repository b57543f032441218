#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 4000U
#define RECORDED_DIGEST UINT64_C(0xBAAB38C814AAFFB9)
#include "chains.h"
