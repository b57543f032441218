/* davar tests - three axes at once are three instances: the same bits, in the order x, y, z. */
#include "davar/axes.h"

#include "stream_fixture.h"

#include <string.h>

#define SAMPLES 300U

static davar_axes_t axes;
static davar_t alone[DAVAR_AXES];
static uint64_t axes_memory[3U * 1024U];
static uint64_t alone_memory[DAVAR_AXES][1024];

static int16_t sample_of(uint32_t axis, uint32_t i)
{
    return (int16_t)((int32_t)(axis + 1U) * ripple((axis * 13U) + i));
}

static void push_alone(int type, uint32_t axis, uint32_t i)
{
    const int16_t count = sample_of(axis, i);
    const int32_t wide = count;
    const float rate = (float)count;
    switch (type) {
    case 0:
        davar_push_q15(&alone[axis], &count, 1U);
        break;
    case 1:
        davar_push_q31(&alone[axis], &wide, 1U);
        break;
    default:
        davar_push_f32(&alone[axis], &rate, 1U);
        break;
    }
}

static void push_together(int type, uint32_t i)
{
    switch (type) {
    case 0:
        davar_axes_push_q15(&axes, sample_of(0U, i), sample_of(1U, i), sample_of(2U, i));
        break;
    case 1:
        davar_axes_push_q31(&axes, sample_of(0U, i), sample_of(1U, i), sample_of(2U, i));
        break;
    default:
        davar_axes_push_f32(&axes, (float)sample_of(0U, i), (float)sample_of(1U, i), (float)sample_of(2U, i));
        break;
    }
}

typedef davar_status_t (*init_axes_t)(davar_axes_t *, const davar_config_t *, void *, size_t);
typedef davar_status_t (*init_t)(davar_t *, const davar_config_t *, void *, size_t);
typedef size_t (*size_of_t)(const davar_config_t *);

static const init_axes_t init_axes[3] = {davar_axes_init_q15, davar_axes_init_q31, davar_axes_init_f32};
static const init_t init_alone[3] = {davar_init_q15, davar_init_q31, davar_init_f32};
static const size_of_t size_of[3] = {davar_memory_size_q15, davar_memory_size_q31, davar_memory_size_f32};

static void expect_the_same_results(uint32_t *results)
{
    davar_result_t expected;
    for (uint32_t axis = 0U; axis < DAVAR_AXES; axis++) {
        memset(&expected, 0, sizeof expected);
        memset(&result, 0, sizeof result);
        const bool waits = davar_take(&alone[axis], &expected);
        if (waits) {
            TEST_ASSERT_EQUAL_INT((int)axis, davar_axes_take(&axes, &result));
            TEST_ASSERT_EQUAL_MEMORY(&expected, &result, sizeof expected);
            (*results)++;
        }
    }
    TEST_ASSERT_EQUAL_INT(-1, davar_axes_take(&axes, &result));
}

static void test_three_axes_are_three_instances(void)
{
    for (int type = 0; type < 3; type++) {
        uint32_t results = 0U;
        TEST_ASSERT_EQUAL(DAVAR_OK, init_axes[type](&axes, &config, axes_memory, 3U * size_of[type](&config)));
        for (uint32_t axis = 0U; axis < DAVAR_AXES; axis++) {
            TEST_ASSERT_EQUAL(DAVAR_OK,
                              init_alone[type](&alone[axis], &config, alone_memory[axis], sizeof alone_memory[axis]));
        }
        for (uint32_t i = 0U; i < SAMPLES; i++) {
            if (i == 100U) {
                davar_axes_gap(&axes, 2U);
            }
            push_together(type, i);
            for (uint32_t axis = 0U; axis < DAVAR_AXES; axis++) {
                if (i == 100U) {
                    davar_gap(&alone[axis], 2U);
                }
                push_alone(type, axis, i);
            }
            expect_the_same_results(&results);
        }
        TEST_ASSERT_GREATER_THAN_UINT32(DAVAR_AXES * 100U, results);
        TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&axes.axis[2]).missing);
    }
}

static void test_a_refusal_is_that_of_init(void)
{
    const size_t each = davar_memory_size_q15(&config);
    TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE, davar_axes_init_q15(&axes, &config, axes_memory, (3U * each) - 1U));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_axes_init_q15(&axes, &config, NULL, 3U * each));
    config.stride = 0U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STRIDE, davar_axes_init_q31(&axes, &config, axes_memory, sizeof axes_memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_STRIDE, davar_axes_init_f32(&axes, &config, axes_memory, sizeof axes_memory));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_three_axes_are_three_instances);
    RUN_TEST(test_a_refusal_is_that_of_init);
    return UNITY_END();
}
