#include "../fuzz/fuzz_floors.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 3000U
#define RECORDED_DIGEST UINT64_C(0xC11C9ECCC4407040)
#include "chains.h"
