/* The smallest user of the installed library: pushes a constant rate and expects a result without
 * noise. */
#include "davar/fit.h"
#include <davar/davar.h>
#include <stdio.h>

static const uint32_t taus[] = {1, 2, 4};
static uint64_t memory[2048];
static davar_t davar;
static davar_plan_t plan; /* of the fit */

int main(void)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.window.longest = 60;
    config.window.shortest = 40;
    config.moments.segment = 10;
    config.taus = taus;
    config.tau_count = 3;

    const davar_status_t status = davar_init_q15(&davar, &config, memory, sizeof memory);
    if (status != DAVAR_OK) {
        puts(davar_status_text(status));
        return 1;
    }
    davar_plan_init_white(&plan, taus, 3);
    davar_result_t result = {0};
    const int16_t count = 7;
    for (int i = 0; i < 100; i++) {
        davar_push_q15(&davar, &count, 1);
        if (davar_take(&davar, &result)) {
            davar_fit(&plan, config.rate_hz, &result);
        }
    }
    printf("davar %d.%d.%d epoch %d window %d\n", DAVAR_VERSION_MAJOR, DAVAR_VERSION_MINOR,
           DAVAR_VERSION_PATCH, (int)result.epoch, (int)result.window_samples);
    return 0;
}
