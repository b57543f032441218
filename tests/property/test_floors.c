#include "../fuzz/fuzz_floors.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 3000U
#define RECORDED_DIGEST UINT64_C(0x7EBA7F6D17B11CFC)
#include "chains.h"
