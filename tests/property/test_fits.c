#include "../fuzz/fuzz_fits.c" /* NOLINT(bugprone-suspicious-include): the same inputs, in ctest */

#define RECORDED_INPUTS 600U
#define RECORDED_DIGEST UINT64_C(0xCC52CE5D8C9E57DF)
#include "chains.h"
