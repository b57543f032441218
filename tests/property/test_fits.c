#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 300U
#define RECORDED_DIGEST UINT64_C(0xAD6EB0A1D3BE8551)
#include "chains.h"
