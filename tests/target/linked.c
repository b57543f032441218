/* davar tests - the smallest program for each use of the library, to measure the code that it
 * links. WHAT: 0 nothing; 1 Allan deviations; 2 also the angle random walk with a plan of
 * tools/davar-plan; 3 with a plan computed at run time; 4 everything except law glr: five terms,
 * gaps, flush, reset, the saved state, the monitor and frames; 5 also law glr. */
#include "davar/can.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"
#include "davar/state.h"

#define TAUS 4U

volatile int16_t input;
volatile double output;

int main(void);
void _start(void);
void _exit(int status);

#if WHAT > 0
static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U};
static const davar_config_t config = {.rate_hz = 100.0,
                                      .unit_per_count = 0.01,
                                      .taus = taus,
                                      .tau_count = TAUS,
                                      .window.longest = 600U,
                                      .window.shortest = 600U,
#if WHAT > 3
#if WHAT == 5
                                      .law = &davar_law_glr_q15,
#else
                                      .law = &davar_law_or,
#endif
                                      .moments.segment = 100U,
                                      .moments.kurtosis_high = 3.3,
                                      .moments.contribution_high = 0.07,
                                      .stride = 60U,
#else
                                      .stride = 1U,
#endif
                                      .window.gaps_max = 4U};
static uint64_t memory[1024];
static davar_t davar;
static davar_result_t result;
#endif

#if WHAT == 2
extern davar_plan_t plan;
#elif WHAT > 2
static davar_plan_t plan;
#endif

#if WHAT > 3
static davar_storage_t storage;
static davar_encoder_t encoder;
static davar_frame_t frame;
static davar_can_health_t health;
static davar_monitor_t monitor;
static davar_misfit_t misfit;

static void more(void)
{
    static davar_model_tau_t model[TAUS];
    if (!davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, DAVAR_SEND_ADEV) ||
        (davar_monitor_init(&monitor, model, TAUS, DAVAR_MONITOR_MEMORY) != DAVAR_MONITOR_OK)) {
        return;
    }
    davar_gap(&davar, 1U);
    (void)davar_flush(&davar);
    davar_reset(&davar);
    (void)davar_state_save(&davar, &storage);
    (void)davar_state_restore(&davar, &storage);
    davar_monitor_update(&monitor, &result, &misfit);
    davar_encoder_begin(&encoder, &result, NULL, &health);
    (void)davar_encoder_next(&encoder, &frame);
    output = (double)davar_health(&davar).gaps;
}
#endif

int main(void)
{
#if WHAT > 0
    if (davar_init_q15(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        return 1;
    }
#endif
#if WHAT > 2
    davar_plan_init_white(&plan, taus, TAUS);
#endif
    for (;;) {
        const int16_t sample = input;
#if WHAT == 0
        output = sample;
#else
        davar_push_q15(&davar, &sample, 1U);
        if (davar_take(&davar, &result)) {
            output = result.tau[0].adev;
#if WHAT == 2
            (void)davar_fit_white_ready(&plan, 100.0, &result);
#elif WHAT == 3
            (void)davar_fit_white(&plan, 100.0, &result);
#elif WHAT > 3
            davar_fit(&plan, 100.0, &result);
            more();
#endif
            output = result.coefficient[DAVAR_ANGLE_RANDOM_WALK].value;
        }
#endif
    }
}

void _start(void)
{
    (void)main();
}

void _exit(int status)
{
    (void)status;
    for (;;) {
    }
}
