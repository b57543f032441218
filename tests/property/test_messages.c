#include "../fuzz/fuzz_messages.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 10000U
#define RECORDED_DIGEST UINT64_C(0x9822538A00EC1DF2)
#include "chains.h"
