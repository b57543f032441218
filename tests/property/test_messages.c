#include "../fuzz/fuzz_messages.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 10000U
#define RECORDED_DIGEST UINT64_C(0x005E43ABDF2F4764)
#include "chains.h"
