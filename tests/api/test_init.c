/* davar tests - the requirements and errors of init. */
#include "davar/cascade.h"
#include "davar/monitor.h"
#include "davar/select.h"
#include "davar/state.h"
#include "davar_law_id.h"
#include "stream_fixture.h"

#include <math.h>
#include <string.h>

static void refused(davar_status_t expected)
{
    davar_t untouched;
    memset(&untouched, 0xA5, sizeof untouched);
    davar_t copy = untouched;
    TEST_ASSERT_EQUAL(expected, davar_init_q15(&untouched, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL_MEMORY(&copy, &untouched, sizeof copy);
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_q15(&config));
    setUp();
}

static void test_each_bad_setting_is_rejected_with_its_own_code(void)
{
    static const uint32_t unsorted[2] = {2U, 2U};
    static const uint32_t zero[2] = {0U, 2U};
    static const uint32_t long_tau[2] = {1U, 21U};
    const double bad_numbers[] = {0.0, -1.0, (double)NAN, (double)INFINITY};
    for (unsigned i = 0U; i < 4U; i++) {
        config.rate_hz = bad_numbers[i];
        refused(DAVAR_ERR_RATE);
        config.unit_per_count = bad_numbers[i];
        refused(DAVAR_ERR_SCALE);
        config.full_scale = bad_numbers[i];
        TEST_ASSERT_EQUAL(DAVAR_ERR_SCALE, davar_init_f32(&davar, &config, memory, sizeof memory));
        TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_f32(&config));
        setUp();
        config.full_scale = 1.0;
        config.unit_per_count = bad_numbers[i]; /* not checked for floats */
        TEST_ASSERT_NOT_EQUAL(0U, davar_memory_size_f32(&config));
        setUp();
    }
    const double far[] = {0.999e-20,
                          1.001e20}; /* in the range of float, outside the range of the quantum */
    for (unsigned i = 0U; i < 2U; i++) {
        config.full_scale = far[i];
        TEST_ASSERT_EQUAL(DAVAR_ERR_SCALE, davar_init_f32(&davar, &config, memory, sizeof memory));
        config.full_scale = (i == 0U) ? 1e-20 : 1e20;
        TEST_ASSERT_NOT_EQUAL(DAVAR_ERR_SCALE,
                              davar_init_f32(&davar, &config, memory, sizeof memory));
        setUp();
    }
    config.sample_bits = 17U, refused(DAVAR_ERR_SAMPLE_BITS);
    config.sample_bits = 1U, refused(DAVAR_ERR_SAMPLE_BITS);
    config.law = &davar_law_glr_q31, config.moments.segment = 0U, refused(DAVAR_ERR_LAW);
    config.window.longest = 2U, refused(DAVAR_ERR_WINDOW_MAX);
    config.window.longest = 65538U, refused(DAVAR_ERR_WINDOW_MAX);
    config.window.shortest = 0U, refused(DAVAR_ERR_WINDOW_MIN);
    config.window.shortest = 42U, refused(DAVAR_ERR_WINDOW_MIN);
    config.moments.segment = 0U, refused(DAVAR_ERR_SEGMENT);
    config.moments.segment = 20U, refused(DAVAR_ERR_SEGMENT);
    config.moments.kurtosis_low = -1.0, refused(DAVAR_ERR_KURTOSIS);
    config.moments.kurtosis_low = 4.0, refused(DAVAR_ERR_KURTOSIS);
    config.moments.kurtosis_high = (double)NAN, refused(DAVAR_ERR_KURTOSIS);
    config.moments.contribution_low = 1.0, refused(DAVAR_ERR_CONTRIBUTION);
    config.moments.contribution_high = (double)INFINITY, refused(DAVAR_ERR_CONTRIBUTION);
    config.window.shrink = 1U << 31U, refused(DAVAR_ERR_SHRINK);
    config.stride = 0U, refused(DAVAR_ERR_STRIDE);
    config.stride = (1U << 24U) + 1U, refused(DAVAR_ERR_STRIDE);
    config.stride = config.window.longest + 1U, refused(DAVAR_ERR_STRIDE_LONG);
    config.engine = &davar_engine_grid_q31, refused(DAVAR_ERR_ENGINE);
    config.tau_count = 0U, refused(DAVAR_ERR_TAU_COUNT);
    config.tau_count = DAVAR_TAUS_MAX + 1U, refused(DAVAR_ERR_TAU_COUNT);
    config.taus = unsorted, config.tau_count = 2U, refused(DAVAR_ERR_TAU_ORDER);
    config.taus = zero, config.tau_count = 2U, refused(DAVAR_ERR_TAU_ZERO);
    config.taus = long_tau, config.tau_count = 2U, refused(DAVAR_ERR_TAU_LONG);
    config.taus = NULL, refused(DAVAR_ERR_NULL);
}

static void accepted(void)
{
    TEST_ASSERT_NOT_EQUAL(0U, davar_memory_size_q15(&config));
    setUp();
}

/* The last value of each range, and the first one outside. */
static void test_each_range_ends_where_it_says(void)
{
    static const double ends[2] = {1e-20, 1e20};
    for (unsigned i = 0U; i < 2U; i++) {
        config.full_scale = ends[i];
        TEST_ASSERT_NOT_EQUAL(0U, davar_memory_size_f32(&config));
        config.full_scale = nextafter(ends[i], (i == 0U) ? 0.0 : 1e30);
        TEST_ASSERT_EQUAL(0U, davar_memory_size_f32(&config));
        setUp();
    }
    static const double far[2] = {1e-50, 1e50};
    for (unsigned i = 0U; i < 2U; i++) {
        const double beyond = (i == 0U) ? 0.0 : 1e60;
        config.rate_hz = far[i], accepted();
        config.rate_hz = nextafter(far[i], beyond), refused(DAVAR_ERR_RATE);
        config.unit_per_count = far[i], accepted();
        config.unit_per_count = nextafter(far[i], beyond), refused(DAVAR_ERR_SCALE);
    }
    config.moments.kurtosis_high = 1e300, accepted();
    config.moments.kurtosis_high = 1.001e300, refused(DAVAR_ERR_KURTOSIS);
    config.moments.contribution_high = 1e300, accepted();
    config.moments.contribution_high = 1.001e300, refused(DAVAR_ERR_CONTRIBUTION);
    config.sample_bits = 2U, accepted();
    config.sample_bits = 16U, accepted();
    config.window.shortest = config.window.longest, accepted();
    config.moments.segment = config.window.shortest - 1U, accepted();
    config.moments.segment = config.window.shortest, refused(DAVAR_ERR_SEGMENT);
    config.moments.kurtosis_low = config.moments.kurtosis_high, accepted();
    config.moments.kurtosis_low = nextafter(config.moments.kurtosis_high, 1e30),
    refused(DAVAR_ERR_KURTOSIS);
    config.moments.contribution_low = config.moments.contribution_high, accepted();
    config.moments.contribution_low = nextafter(config.moments.contribution_high, 1e30),
    refused(DAVAR_ERR_CONTRIBUTION);
    config.stride = config.window.longest, accepted();
}

static void test_bad_pointers_and_memory_are_rejected(void)
{
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q15(NULL, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q15(&davar, &config, NULL, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q31(&davar, NULL, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE,
                      davar_init_q15(&davar, &config, memory, davar_memory_size_q15(&config) - 1U));
    TEST_ASSERT_EQUAL(
        DAVAR_ERR_MEMORY_ALIGN,
        davar_init_q15(&davar, &config, (unsigned char *)memory + 4, sizeof memory - 8U));
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_f32(NULL));
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_q31(NULL));
}

/* If size_t has 32 bits, the size of the largest grids does not fit: it must then look too large,
 * never small. */
static void test_memory_never_shrinks_as_windows_grow(void)
{
    static uint32_t many[32];
    for (uint32_t t = 0U; t < 32U; t++) {
        many[t] = t + 1U;
    }
    config.taus = many;
    config.tau_count = 32U;
    config.stride = 2U;
    config.engine = &davar_engine_grid_q31;
    size_t before = 0U;
    for (config.window.longest = 65536U; config.window.longest <= 16777216U;
         config.window.longest += 32768U) {
        const size_t bytes = davar_memory_size_q31(&config);
        TEST_ASSERT_GREATER_OR_EQUAL_size_t(before, bytes);
        before = bytes;
    }
    TEST_ASSERT_GREATER_THAN_size_t(4200000000U, before);
}

static const char *of_davar(int i)
{
    return davar_status_text((davar_status_t)i);
}

static const char *of_cascade(int i)
{
    return davar_cascade_status_text((davar_cascade_status_t)i);
}

static const char *of_monitor(int i)
{
    return davar_monitor_status_text((davar_monitor_status_t)i);
}

static const char *of_noise(int i)
{
    return davar_noise_text((davar_noise_t)i);
}

static const char *of_select(int i)
{
    return davar_select_status_text((davar_select_status_t)i);
}

static const char *of_state(int i)
{
    return davar_state_status_text((davar_state_status_t)i);
}

/* 8, 12 and 16 were the codes of centred windows. No other error may get them. */
static void test_every_code_has_its_own_words(void)
{
    static const struct {
        const char *(*words)(int);
        int last;
        uint32_t retired;
    } kinds[] = {
        {of_davar, DAVAR_ERR_TAU_OVERFLOW, 0x11100U},
        {of_cascade, DAVAR_CASCADE_ERR_MEMORY_ALIGN, 0U},
        {of_monitor, DAVAR_MONITOR_ERR_MEMORY, 0U},
        {of_noise, DAVAR_NOISE_FILTERED, 0U},
        {of_select, DAVAR_SELECT_ERR_TOLERANCE, 0U},
        {of_state, DAVAR_STATE_ERR_FOREIGN, 0U},
    };
    for (size_t k = 0U; k < sizeof kinds / sizeof kinds[0]; k++) {
        for (int i = 0; i <= kinds[k].last; i++) {
            const bool is_retired = ((kinds[k].retired >> (unsigned)i) & 1U) != 0U;
            const char *const words = kinds[k].words(i);
            TEST_ASSERT_EQUAL(is_retired, strncmp("unknown ", words, 8U) == 0);
            for (int j = 0; (j < i) && !is_retired; j++) {
                TEST_ASSERT_TRUE(strcmp(words, kinds[k].words(j)) != 0);
            }
        }
        TEST_ASSERT_EQUAL_STRING_LEN("unknown ", kinds[k].words(99), 8U);
    }
}

/* A stride above 1 adds a copy of the sums and of the moments, whatever the stride. */
static void test_the_memory_macros_include_a_stride(void)
{
    const uint32_t last = 1U << (TAUS - 1U);
    for (uint32_t stride = 2U; stride <= config.window.longest; stride++) {
        config.stride = stride;
        config.law = ((stride % 4U) < 2U) ? &davar_law_or : NULL;
        config.moments.segment = (config.law == NULL) ? 0U : 1U;
        const uint32_t longest = config.window.longest;
        const uint32_t segment = config.moments.segment;
        const uint32_t gaps = config.window.gaps_max;
        const size_t q15 = DAVAR_MEMORY_SLIDING(1U, longest, segment, stride, last, TAUS, gaps);
        const size_t q31 = DAVAR_MEMORY_SLIDING(2U, longest, segment, stride, last, TAUS, gaps);
        TEST_ASSERT_GREATER_OR_EQUAL_size_t(davar_memory_size_q15(&config), q15);
        TEST_ASSERT_GREATER_OR_EQUAL_size_t(davar_memory_size_q31(&config), q31);
        TEST_ASSERT_LESS_OR_EQUAL_size_t(davar_memory_size_q15(&config) + 24U, q15);
        TEST_ASSERT_LESS_OR_EQUAL_size_t(davar_memory_size_q31(&config) + 24U, q31);
    }
}

/* Any residues of both windows and the segment, with and without an adaptive window. */
static void test_the_memory_macros_of_a_grid_are_enough_for_init(void)
{
    const uint32_t last = 1U << (TAUS - 1U);
    for (uint32_t i = 0U; i < 60000U; i++) {
        const uint32_t draw = i * 2654435761U;
        config.stride = 2U + ((draw >> 8U) % 90U);
        config.window.shortest = 2U * (last + ((draw >> 16U) % 97U));
        config.window.longest = config.window.shortest + (2U * ((draw >> 4U) % 211U));
        config.stride =
            (config.stride < config.window.longest) ? config.stride : config.window.longest;
        config.moments.segment = 1U + ((draw >> 12U) % (config.window.shortest - 1U));
        config.window.gaps_max = (uint16_t)(i % 7U);
        config.law = ((i % 3U) == 0U) ? NULL : &davar_law_or;
        const uint32_t longest = config.window.longest;
        const uint32_t shortest = (config.law == NULL) ? longest : config.window.shortest;
        const uint32_t segment = config.moments.segment;
        const uint32_t gaps = config.window.gaps_max;
        if ((config.law != NULL) && (shortest == longest)) {
            continue; /* a law that cannot change the window */
        }
        for (uint32_t words = 1U; words < 3U; words++) {
            config.engine = davar_grid_of(true, words == 2U);
            const size_t need =
                (words == 2U) ? davar_memory_size_q31(&config) : davar_memory_size_q15(&config);
            const size_t macro = DAVAR_MEMORY_ON_GRID(words, longest, shortest, segment,
                                                      config.stride, last, TAUS, gaps);
            TEST_ASSERT_GREATER_THAN_size_t(0U, need);
            TEST_ASSERT_GREATER_OR_EQUAL_size_t(need, macro);
            TEST_ASSERT_LESS_OR_EQUAL_size_t(need + 40U, macro);
        }
    }
}

/* The macro includes 12 words of padding, for 64-bit integers that are aligned to 8 bytes. i386
 * aligns them to 4 and needs no padding. The rest is at most 8 bytes above the need: a fixed part is
 * rounded, for pointers of any size. */
static void check_memory_of_glr(size_t need, size_t macro)
{
    typedef struct {
        uint32_t word;
        uint64_t wide;
    } padded_t;
    const size_t no_padding = 12U * (16U - sizeof(padded_t));
    TEST_ASSERT_GREATER_THAN_size_t(0U, need);
    TEST_ASSERT_GREATER_OR_EQUAL_size_t(need + no_padding, macro);
    TEST_ASSERT_LESS_OR_EQUAL_size_t(need + no_padding + 8U, macro);
}

static void test_the_memory_macro_of_glr_is_enough_and_no_more(void)
{
    const uint32_t last = 1U << (TAUS - 1U);
    config.moments.segment = 0U;
    config.window.shortest = 20U;
    config.window.shrink = 64U;
    for (uint32_t i = 0U; i < 3000U; i++) {
        const uint32_t draw = i * 2654435761U;
        const uint32_t block = 5U + ((draw >> 8U) % 60U);
        config.glr.block = block;
        config.window.shortest = 2U * block;
        config.window.longest = (8U * block) + ((draw >> 4U) % (700U * block));
        config.stride = 2U + ((draw >> 16U) % 500U);
        config.stride =
            (config.stride < config.window.longest) ? config.stride : config.window.longest;
        config.window.gaps_max = (uint16_t)(i % 7U);
        const uint32_t gaps = config.window.gaps_max;
        config.law = &davar_law_glr_q15;
        check_memory_of_glr(
            davar_memory_size_q15(&config),
            DAVAR_MEMORY_OF_GLR(1U, config.window.longest, block, last, TAUS, gaps));
        config.law = &davar_law_glr_q31;
        check_memory_of_glr(
            davar_memory_size_q31(&config),
            DAVAR_MEMORY_OF_GLR(2U, config.window.longest, block, last, TAUS, gaps));
    }
}

static void test_exactly_the_required_memory_is_never_exceeded(void)
{
    for (uint32_t stride = 1U; stride < 24U; stride++) {
        config.stride = (stride % 12U) + 1U;
        config.engine = (stride < 12U) ? NULL : &davar_engine_grid_q15;
        const size_t bytes = davar_memory_size_q15(&config);
        memset(memory, 0xA5, sizeof memory);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, bytes));
        (void)feed(0U, 500U);
        TEST_ASSERT_EACH_EQUAL_HEX8(0xA5, (unsigned char *)memory + bytes, 256U);
    }
}

/* True if a window of 2^w samples and a cluster of m, which reach W m^2 = 2^(sum_bits - 2 bits)
 * (2.4), are rejected and m - 1 is accepted. */
static void test_the_last_cluster_that_cannot_overflow(void)
{
    static uint32_t m;
    config.taus = &m;
    config.tau_count = 1U;
    config.window.gaps_max = 0U;
    config.window.longest = 65536U;
    config.window.shortest = 65536U;
    for (uint8_t bits = 14U; bits <= 16U; bits++) {
        config.sample_bits = bits;
        m = UINT32_C(1) << (24U - bits); /* 2^16 m^2 = 2^(64 - 2 bits) */
        TEST_ASSERT_EQUAL(DAVAR_ERR_TAU_OVERFLOW,
                          davar_init_q15(&davar, &config, memory, sizeof memory));
        m--;
        TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE, davar_init_q15(&davar, &config, memory, 8U));
    }
    config.window.longest = 16777216U;
    config.window.shortest = 16777216U;
    for (uint8_t bits = 30U; bits <= 32U; bits++) {
        config.sample_bits = bits;
        m = UINT32_C(1) << (52U - bits); /* 2^24 m^2 = 2^(128 - 2 bits) */
        TEST_ASSERT_EQUAL(DAVAR_ERR_TAU_OVERFLOW,
                          davar_init_q31(&davar, &config, memory, sizeof memory));
        m--;
        TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE, davar_init_q31(&davar, &config, memory, 8U));
    }
    config.full_scale = 1.0;
    m = UINT32_C(1) << 21U; /* floats have 31 bits */
    TEST_ASSERT_EQUAL(DAVAR_ERR_TAU_OVERFLOW,
                      davar_init_f32(&davar, &config, memory, sizeof memory));
    m--;
    TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE, davar_init_f32(&davar, &config, memory, 8U));
}

/* Checks the macro with named settings, for the configurations of DAVAR_SONG and DAVAR_FIXED. */
static void check_named(size_t bytes, uint32_t longest, uint32_t shortest, uint32_t stride,
                        const uint32_t *sizes, uint8_t count, int type)
{
    const davar_config_t song = {.rate_hz = 100.0,
                                 .unit_per_count = 0.01,
                                 .full_scale = 100.0,
                                 DAVAR_SONG(longest, shortest),
                                 .stride = stride,
                                 .taus = sizes,
                                 .tau_count = count};
    const davar_config_t fixed = {.rate_hz = 100.0,
                                  .unit_per_count = 0.01,
                                  .full_scale = 100.0,
                                  DAVAR_FIXED(longest),
                                  .stride = stride,
                                  .taus = sizes,
                                  .tau_count = count};
    const davar_config_t one = (longest == shortest) ? fixed : song;
    const size_t needed = (type == 0)   ? davar_memory_size_q15(&one)
                          : (type == 1) ? davar_memory_size_q31(&one)
                                        : davar_memory_size_f32(&one);
    TEST_ASSERT_GREATER_THAN_size_t(0U, needed);
    TEST_ASSERT_LESS_OR_EQUAL_size_t(bytes, needed);
    TEST_ASSERT_EQUAL_size_t(0U, bytes % 8U);
}

static void test_the_named_memory_macro_is_enough(void)
{
    static const uint32_t octaves[] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U};
    static const uint32_t far[] = {1U, 250U};
#define NAMED(type, number, W, w, K, sizes, m, T)                                                  \
    check_named(DAVAR_MEMORY(type, longest(W), shortest(w), stride(K), largest(m), taus(T)), W, w, \
                K, sizes, T, number)
    NAMED(Q15, 0, 600U, 400U, 60U, octaves, 128U, 8U);
    NAMED(Q15, 0, 600U, 400U, 1U, octaves, 128U, 8U);
    NAMED(Q15, 0, 600U, 20U, 1U, far, 250U, 2U); /* spans longer than the shortest window */
    NAMED(Q15, 0, 600U, 600U, 7U, octaves, 128U, 8U);
    NAMED(Q31, 1, 600U, 600U, 1U, octaves, 128U, 8U);
    NAMED(Q31, 1, 602U, 300U, 23U, far, 250U, 2U);
    NAMED(F32, 2, 600U, 400U, 60U, octaves, 128U, 8U);
    NAMED(F32, 2, 600U, 400U, 1U, octaves, 128U, 8U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_bad_setting_is_rejected_with_its_own_code);
    RUN_TEST(test_each_range_ends_where_it_says);
    RUN_TEST(test_bad_pointers_and_memory_are_rejected);
    RUN_TEST(test_memory_never_shrinks_as_windows_grow);
    RUN_TEST(test_every_code_has_its_own_words);
    RUN_TEST(test_the_memory_macros_include_a_stride);
    RUN_TEST(test_the_memory_macros_of_a_grid_are_enough_for_init);
    RUN_TEST(test_the_memory_macro_of_glr_is_enough_and_no_more);
    RUN_TEST(test_exactly_the_required_memory_is_never_exceeded);
    RUN_TEST(test_the_last_cluster_that_cannot_overflow);
    RUN_TEST(test_the_named_memory_macro_is_enough);
    return UNITY_END();
}
