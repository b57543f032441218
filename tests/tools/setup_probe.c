/* davar tests - the setup that tools/davar-plan wrote, beside instances of the library that get the
 * samples of each axis directly: same results, curves, gaps and counters.
 *
 * SAMPLE, SUFFIX: of the type. SIGMA: of the noise, 1 deg/s. CASCADE: there is a curve. WHOLE_CURVE: it has
 * a fit. Prints present, value, low and high of each ARW of axis 0. */
#include "davar_setup.c"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AXES DAVAR_SETUP_AXES
#define BLOCK_MOST 40U
#define PUSHES 900U /* of 20 samples on average */
#define JOIN(name, suffix) name##suffix
#define WITH(name, suffix) JOIN(name, suffix)
#define TYPED(name) WITH(name, SUFFIX)
#define REQUIRE(condition) require((condition), __LINE__)

static davar_t own[AXES];
static uint64_t own_memory[AXES][sizeof memory[0] / 8U];
#ifdef CASCADE
static davar_cascade_t own_slow[AXES];
static uint64_t own_stages[AXES][sizeof stages[0] / 8U];
#endif
static uint64_t state = 1U;

static void require(bool condition, int line)
{
    if (!condition) {
        (void)printf("line %d\n", line);
        exit(1);
    }
}

/* The sum of twelve uniform variates. */
static SAMPLE noise(void)
{
    double sum = -6.0;
    for (int k = 0; k < 12; k++) {
        state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
        sum += (double)(state >> 11U) / 9007199254740992.0;
    }
    return (SAMPLE)(SIGMA * (sum + 50.0));
}

static void start(void)
{
    REQUIRE(davar_setup_start() == DAVAR_OK);
    REQUIRE(davar_setup_config() == &config);
    for (uint8_t a = 0U; a < AXES; a++) {
        REQUIRE(TYPED(davar_init_)(&own[a], &config, own_memory[a], sizeof own_memory[a]) ==
                DAVAR_OK);
#ifdef CASCADE
        REQUIRE(TYPED(davar_cascade_init_)(&own_slow[a], &slow, own_stages[a],
                                           sizeof own_stages[a]) == DAVAR_CASCADE_OK);
        REQUIRE(davar_setup_curve(a) == NULL);
#endif
        REQUIRE((davar_setup_instance(a) == &gyro[a]) && (davar_setup_take(a) == NULL));
    }
}

static void push(size_t count)
{
    SAMPLE all[AXES * BLOCK_MOST];
    SAMPLE one[AXES][BLOCK_MOST];
    for (size_t i = 0U; i < count; i++) {
        for (size_t a = 0U; a < AXES; a++) {
            one[a][i] = all[(AXES * i) + a] = noise();
        }
    }
    davar_setup_push(all, count);
    for (size_t a = 0U; a < AXES; a++) {
        TYPED(davar_push_)(&own[a], one[a], count);
#ifdef CASCADE
        TYPED(davar_cascade_push_)(&own_slow[a], one[a], count);
#endif
    }
}

static void lose(uint32_t missing)
{
    davar_setup_gap(missing);
    for (size_t a = 0U; a < AXES; a++) {
        davar_gap(&own[a], missing);
#ifdef CASCADE
        davar_cascade_gap(&own_slow[a], missing);
#endif
    }
}

static void require_same_taus(const davar_result_t *found, const davar_result_t *mine, uint8_t from)
{
    REQUIRE(found->tau_count == (uint8_t)(from + mine->tau_count));
    for (uint8_t t = 0U; t < mine->tau_count; t++) {
        const davar_adev_t *const tau = &found->tau[from + t];
        REQUIRE((tau->m == mine->tau[t].m) && (tau->differences == mine->tau[t].differences) &&
                (memcmp(&tau->adev, &mine->tau[t].adev, sizeof tau->adev) == 0));
    }
}

static bool take(uint8_t axis)
{
    static davar_result_t mine;
    const davar_result_t *const found = davar_setup_take(axis);
    const bool has = davar_take(&own[axis], &mine);
    REQUIRE((found != NULL) == has);
    if (has) {
        const davar_coefficient_t *const arw = &found->coefficient[DAVAR_ANGLE_RANDOM_WALK];
        REQUIRE((found->epoch == mine.epoch) && (found->window_samples == mine.window_samples));
        require_same_taus(found, &mine, 0U);
        REQUIRE(davar_setup_take(axis) == NULL);
        if (axis == 0U) {
            (void)printf("%d %g %g %g\n", arw->present, arw->value, arw->low, arw->high);
        }
    }
    return has;
}

#ifdef CASCADE
static void curve(uint8_t axis)
{
    static davar_result_t mine;
    static davar_result_t again;
    const bool has_result = davar_take(&own[axis], &mine);
    memset(&mine, 0, sizeof mine);
    REQUIRE(davar_cascade_append(&own_slow[axis], &mine));
    const davar_result_t *const found = davar_setup_curve(axis);
    REQUIRE(found != NULL);
#ifdef WHOLE_CURVE
    const davar_coefficient_t *const arw = &found->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    REQUIRE(arw->present && (fabs(arw->value - 6.0) < 1.0) && (arw->high < 9.0));
    require_same_taus(found, &mine, config.tau_count);
    for (uint8_t t = 0U; t < config.tau_count; t++) {
        REQUIRE((found->tau[t].m == taus[t]) && ((found->tau[t].differences > 0U) == has_result));
        REQUIRE(isnan(found->tau[t].adev) != has_result);
    }
    REQUIRE(davar_setup_take(axis) == NULL);
#else
    require_same_taus(found, &mine, 0U);
    REQUIRE(!found->coefficient[DAVAR_ANGLE_RANDOM_WALK].present);
    REQUIRE((davar_setup_take(axis) != NULL) == has_result);
#endif
    again = *davar_setup_curve(axis);
    require_same_taus(davar_setup_curve(axis), &again, 0U);
    for (uint8_t t = 0U; t < again.tau_count; t++) {
        const davar_adev_t *const tau = &again.tau[t];
        REQUIRE((tau->differences == 0U) || ((tau->low < tau->adev) && (tau->adev < tau->high)));
    }
}
#endif

static void require_same_health(uint8_t axis)
{
    const davar_health_t found = davar_setup_health(axis);
    const davar_health_t mine = davar_health(&own[axis]);
    REQUIRE(memcmp(&found, &mine, sizeof found) == 0);
}

static void run(void)
{
    for (uint32_t i = 0U; i < PUSHES; i++) {
        push(1U + ((7U * i) % BLOCK_MOST));
        for (uint8_t a = 0U; a < AXES; a++) {
            (void)take(a);
        }
        if (i == 100U) {
            lose(7U);
        }
    }
    do { /* a result of each axis, of which only the first is taken */
        push(1U);
    } while (!take(0U));
}

int main(void)
{
    start();
    for (uint32_t turn = 0U; turn < 2U; turn++) {
        run();
#ifdef CASCADE
        curve(0U);
        curve(AXES - 1U);
        REQUIRE(davar_setup_curve(AXES) == NULL);
#endif
        for (uint8_t a = 0U; a < AXES; a++) {
            require_same_health(a);
            davar_reset(&own[a]);
#ifdef CASCADE
            davar_cascade_reset(&own_slow[a]);
#endif
        }
        REQUIRE(davar_setup_health(0U).missing == 7U);
        davar_setup_restart();
        for (uint8_t a = 0U; a < AXES; a++) {
            require_same_health(a);
        }
    }
    REQUIRE((davar_setup_take(AXES) == NULL) && (davar_setup_instance(AXES) == NULL));
    return (int)davar_setup_health(AXES).missing;
}
