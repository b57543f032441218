#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 4000U
#define RECORDED_DIGEST UINT64_C(0x69301ED35105D2A5)
#include "chains.h"
