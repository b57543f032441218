#include "../fuzz/fuzz_messages.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 1000U
#define RECORDED_DIGEST UINT64_C(0x67E77C7E6BA86ED0)
#include "chains.h"
