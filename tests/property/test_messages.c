#include "../fuzz/fuzz_messages.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 10000U
#define RECORDED_DIGEST UINT64_C(0x965F38C3F0CF8E69)
#include "chains.h"
