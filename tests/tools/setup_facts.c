/* davar tests - what the files of tools/davar-plan pass to the library. This program is the library:
 * it prints each call as a line "function axis values".
 *
 *   setup_facts COUNT BLOCK
 *
 * Pushes COUNT samples of every axis in blocks of BLOCK. Sample i of axis a is 100 a + i. */
#include "davar/fit.h"
#include "davar_setup.c"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#if DAVAR_Q15
#define SUFFIXED(name) name##_q15
#elif !defined(FLOAT)
#define SUFFIXED(name) name##_q31
#else
#define SUFFIXED(name) name##_f32
#endif

static int axis_of(const davar_t *davar)
{
    return (int)(davar - gyro);
}

davar_status_t SUFFIXED(davar_init)(davar_t *davar, const davar_config_t *with, void *at,
                                    size_t bytes)
{
    const int axis = axis_of(davar);
    (void)printf("init %d %d %zu %.17g %.17g %.17g %" PRIu32 " %d", axis, at == memory[axis], bytes,
                 with->rate_hz, with->unit_per_count, with->full_scale, with->stride,
                 (with->engine != NULL) ? 1 : 0);
    (void)printf(" %" PRIu32 " %" PRIu32 " %u %.17g %" PRIu32 " %" PRIu32 " %u\n",
                 with->window.longest, with->window.shortest, (unsigned)with->window.gaps_max,
                 with->glr.false_alarms_per_hour, (uint32_t)with->glr.block,
                 (uint32_t)with->taus[with->tau_count - 1U], (unsigned)with->tau_count);
    return DAVAR_OK;
}

static void print_samples(const char *name, int axis, const SAMPLE *samples, size_t count)
{
    (void)printf("%s %d", name, axis);
    for (size_t i = 0U; i < count; i++) {
        (void)printf(" %g", (double)samples[i]);
    }
    (void)printf("\n");
}

void SUFFIXED(davar_push)(davar_t *davar, const SAMPLE *samples, size_t count)
{
    print_samples("push", axis_of(davar), samples, count);
}

void davar_gap(davar_t *davar, uint32_t missing)
{
    (void)printf("gap %d %" PRIu32 "\n", axis_of(davar), missing);
}

bool davar_take(davar_t *davar, davar_result_t *taken)
{
    taken->window_samples = 1U + (uint32_t)axis_of(davar);
    return davar != &gyro[DAVAR_SETUP_AXES - 1];
}

void davar_reset(davar_t *davar)
{
    (void)printf("reset %d\n", axis_of(davar));
}

davar_health_t davar_health(const davar_t *davar)
{
    const davar_health_t health = {.gaps = 1U + (uint32_t)axis_of(davar)};
    return health;
}

static bool fit(const char *name, const davar_plan_t *plan, double rate_hz, davar_result_t *fitted)
{
    (void)printf("%s %d %d %.17g\n", name, (int)fitted->window_samples - 1,
                 plan == &davar_setup_plan, rate_hz);
    return true;
}

bool davar_fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *fitted)
{
    return fit("fit_white", plan, rate_hz, fitted);
}

bool davar_fit_white_ready(davar_plan_t *plan, double rate_hz, davar_result_t *fitted)
{
    return fit("fit_white_ready", plan, rate_hz, fitted);
}

#ifdef CASCADE
void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *fitted)
{
    (void)fit("fit", plan, rate_hz, fitted);
}

davar_cascade_status_t SUFFIXED(davar_cascade_init)(davar_cascade_t *one,
                                                    const davar_cascade_config_t *with, void *at,
                                                    size_t bytes)
{
    const int axis = (int)(one - cascade);
    (void)printf("slow_init %d %d %zu %.17g %.17g %.17g %" PRIu32 " %u %" PRIu32 "\n", axis,
                 at == stages[axis], bytes, with->rate_hz, with->unit_per_count, with->full_scale,
                 (uint32_t)with->shortest, (unsigned)with->tau_count, (uint32_t)with->clusters);
    return DAVAR_CASCADE_OK;
}

void SUFFIXED(davar_cascade_push)(davar_cascade_t *one, const SAMPLE *samples, size_t count)
{
    print_samples("slow_push", (int)(one - cascade), samples, count);
}

void davar_cascade_gap(davar_cascade_t *one, uint32_t missing)
{
    (void)printf("slow_gap %d %" PRIu32 "\n", (int)(one - cascade), missing);
}

void davar_cascade_reset(davar_cascade_t *one)
{
    (void)printf("slow_reset %d\n", (int)(one - cascade));
}

bool davar_cascade_append(const davar_cascade_t *one, davar_result_t *longer)
{
    (void)printf("append %d %u\n", (int)(one - cascade), (unsigned)longer->tau_count);
    return true;
}

double davar_edf_least(const davar_result_t *of, uint8_t t)
{
    return (double)of->tau[t].m;
}

void davar_chi_square_interval(double edf, double *low, double *high)
{
    *low = edf;
    *high = edf;
}
#endif

struct davar_law {
    int unused;
};
const davar_law_t davar_law_glr_q15;
const davar_law_t davar_law_glr_q31;

struct davar_engine {
    int unused;
};
const davar_engine_t davar_engine_grid_q15;
const davar_engine_t davar_engine_grid_q31;

int main(int argc, char *argv[])
{
    static SAMPLE samples[1000 * DAVAR_SETUP_AXES];
    const size_t count = (argc > 2) ? strtoul(argv[1], NULL, 10) : 0U;
    const size_t block = (argc > 2) ? strtoul(argv[2], NULL, 10) : 1U;
    for (size_t i = 0U; i < (count * DAVAR_SETUP_AXES); i++) {
        samples[i] = (SAMPLE)((100U * (i % DAVAR_SETUP_AXES)) + (i / DAVAR_SETUP_AXES));
    }
    (void)printf("start %d\n", (int)davar_setup_start());
    for (size_t i = 0U; i < count; i += block) {
        davar_setup_push(&samples[i * DAVAR_SETUP_AXES], (count - i < block) ? count - i : block);
    }
    davar_setup_gap(7U);
    for (uint8_t a = 0U; a <= DAVAR_SETUP_AXES; a++) {
        (void)printf("taken %d %d\n", a, davar_setup_take(a) != NULL);
#ifdef CASCADE
        (void)printf("curve %d %d\n", a, davar_setup_curve(a) != NULL);
#endif
    }
    davar_setup_restart();
    for (uint8_t a = 0U; a <= DAVAR_SETUP_AXES; a++) {
        const davar_t *const davar = davar_setup_instance(a);
        (void)printf("instance %d %d\n", a, (davar == NULL) ? -1 : axis_of(davar));
        (void)printf("health %d %d\n", a, (int)davar_setup_health(a).gaps);
    }
    (void)printf("config 0 %d\n", davar_setup_config() == &config);
    return 0;
}
