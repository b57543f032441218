#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 600U
#define RECORDED_DIGEST UINT64_C(0x69DD67267F4D13F4)
#include "chains.h"
