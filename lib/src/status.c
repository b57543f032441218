/* davar - the causes of refusal in words. */
#include "davar/davar.h"

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

const char *davar_status_text(davar_status_t status)
{
    static const char *const text[] = {
        [DAVAR_OK] = "ok",
        [DAVAR_ERR_NULL] = "a pointer is null (taus among them)",
        [DAVAR_ERR_BUILD] = "left out of this build",
        [DAVAR_ERR_MEMORY_SIZE] = "memory smaller than davar_memory_size",
        [DAVAR_ERR_MEMORY_ALIGN] = "memory not aligned to 8 bytes",
        [DAVAR_ERR_RATE] = "rate_hz is not a positive number",
        [DAVAR_ERR_SCALE] = "unit_per_count or full_scale is not a positive number in range",
        [DAVAR_ERR_SAMPLE_BITS] = "sample_bits outside what the number type holds",
        [DAVAR_ERR_MODE] = "mode is neither centred nor trailing",
        [DAVAR_ERR_POLICY] = "policy unknown",
        [DAVAR_ERR_WINDOW_MAX] = "window_max below 4, or too long for the number type",
        [DAVAR_ERR_WINDOW_MIN] = "window_min 0, or above window_max",
        [DAVAR_ERR_WINDOW_ODD] = "window_max or window_min odd in centred mode",
        [DAVAR_ERR_SEGMENT] =
            "segment not smaller than window_min, or 0 with a policy that needs it (fixed and glr do not)",
        [DAVAR_ERR_KURTOSIS] = "kurtosis bounds negative, not finite, or low above high",
        [DAVAR_ERR_CONTRIBUTION] = "contribution bounds negative, not finite, or low above high",
        [DAVAR_ERR_STEP] = "grow or shrink would move a window edge backwards (centred: 0 or 2)",
        [DAVAR_ERR_SHRINK] = "shrink beyond 2^31 samples a stride",
        [DAVAR_ERR_STRIDE] = "stride 0 or above 2^24",
        [DAVAR_ERR_STRIDE_LONG] = "stride above window_max: samples between two windows would never count",
        [DAVAR_ERR_ENGINE] = "engine unknown, or edges for policy glr with a stride above 1",
        [DAVAR_ERR_TRACKING] =
            "policy glr: block, shock_blocks, long_cluster, window_max, window_min, stride or a rate out of range",
        [DAVAR_ERR_TAU_COUNT] = "no cluster size, or more than DAVAR_TAUS_MAX",
        [DAVAR_ERR_TAU_ORDER] = "cluster sizes not strictly ascending",
        [DAVAR_ERR_TAU_ZERO] = "cluster size 0",
        [DAVAR_ERR_TAU_LONG] = "twice the longest cluster size is above window_max",
        [DAVAR_ERR_TAU_OVERFLOW] = "window_max m^2 beyond the exact sums of this type",
        [DAVAR_ERR_STATE_STORAGE] = "storage slot too small, or storage failed",
        [DAVAR_ERR_STATE_NONE] = "no whole image of a state",
        [DAVAR_ERR_STATE_FOREIGN] = "state of another version, number type, configuration or machine",
    };
    return ((size_t)status < COUNT_OF(text)) ? text[status] : "unknown status";
}
