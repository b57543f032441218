/* davar - three axes: every call is one of davar.h, three times. */
#include "davar/axes.h"

/* How much of the memory each axis has: a third, aligned. */
static size_t share_of_memory(size_t bytes)
{
    return (bytes / DAVAR_AXES) & ~(size_t)7U;
}

static void *memory_of_axis(void *memory, size_t share, uint32_t i)
{
    return (memory == NULL) ? NULL : &((unsigned char *)memory)[share * i];
}

davar_status_t davar_axes_init_q15(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes)
{
    const size_t share = share_of_memory(bytes);
    davar_status_t status = DAVAR_OK;
    for (uint32_t i = 0U; (i < DAVAR_AXES) && (status == DAVAR_OK); i++) {
        status = davar_init_q15(&axes->axis[i], config, memory_of_axis(memory, share, i), share);
    }
    return status;
}

davar_status_t davar_axes_init_q31(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes)
{
    const size_t share = share_of_memory(bytes);
    davar_status_t status = DAVAR_OK;
    for (uint32_t i = 0U; (i < DAVAR_AXES) && (status == DAVAR_OK); i++) {
        status = davar_init_q31(&axes->axis[i], config, memory_of_axis(memory, share, i), share);
    }
    return status;
}

davar_status_t davar_axes_init_f32(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes)
{
    const size_t share = share_of_memory(bytes);
    davar_status_t status = DAVAR_OK;
    for (uint32_t i = 0U; (i < DAVAR_AXES) && (status == DAVAR_OK); i++) {
        status = davar_init_f32(&axes->axis[i], config, memory_of_axis(memory, share, i), share);
    }
    return status;
}

void davar_axes_push_q15(davar_axes_t *axes, int16_t x, int16_t y, int16_t z)
{
    davar_push_q15(&axes->axis[0], &x, 1U);
    davar_push_q15(&axes->axis[1], &y, 1U);
    davar_push_q15(&axes->axis[2], &z, 1U);
}

void davar_axes_push_q31(davar_axes_t *axes, int32_t x, int32_t y, int32_t z)
{
    davar_push_q31(&axes->axis[0], &x, 1U);
    davar_push_q31(&axes->axis[1], &y, 1U);
    davar_push_q31(&axes->axis[2], &z, 1U);
}

void davar_axes_push_f32(davar_axes_t *axes, float x, float y, float z)
{
    davar_push_f32(&axes->axis[0], &x, 1U);
    davar_push_f32(&axes->axis[1], &y, 1U);
    davar_push_f32(&axes->axis[2], &z, 1U);
}

void davar_axes_gap(davar_axes_t *axes, uint32_t missing)
{
    for (uint32_t i = 0U; i < DAVAR_AXES; i++) {
        davar_gap(&axes->axis[i], missing);
    }
}

int davar_axes_take(davar_axes_t *axes, davar_result_t *result)
{
    for (uint32_t i = 0U; i < DAVAR_AXES; i++) {
        if (davar_take(&axes->axis[i], result)) {
            return (int)i;
        }
    }
    return -1;
}
