/* The smallest user of every part of the installed library: prints a word of each. */
#include <davar/average.h>
#include <davar/can.h>
#include <davar/can_decode.h>
#include <davar/cascade.h>
#include <davar/davar.h>
#include <davar/floor.h>
#include <davar/kalman.h>
#include <davar/monitor.h>
#include <davar/select.h>
#include <davar/slcan.h>
#include <davar/small.h>
#include <davar/state.h>
#include <davar/telemetry.h>
#include <davar/torn.h>
#include <stdio.h>

int main(void)
{
    davar_average_t average;
    davar_torn_t torn;
    davar_monitor_t monitor;
    davar_telemetry_t telemetry;
    davar_result_t result = {0};
    davar_misfit_t misfit;
    davar_decoded_t decoded;
    const davar_frame_t frame = {.identifier = 1U, .length = 0U};
    const davar_telemetry_address_t nobody = {.node = 0U};
    char text[DAVAR_SLCAN_BYTES];
    static davar_small_t small;
    davar_average_init(&average, 4U);
    davar_torn_init(&torn);
    const davar_model_tau_t model = {.m = 1U, .adev_dps = 1.0};
    const bool monitors =
        davar_monitor_init(&monitor, &model, 1U, DAVAR_MONITOR_MEMORY) == DAVAR_MONITOR_OK;
    davar_monitor_update(&monitor, &result, &misfit);
    printf("parts %s %s %s %s %d %d %d %d %u %u %g\n", davar_cascade_status_text(DAVAR_CASCADE_OK),
           davar_state_status_text(DAVAR_STATE_OK), davar_select_status_text(DAVAR_SELECT_OK),
           davar_floor_status_text(DAVAR_FLOOR_OK), monitors,
           davar_decode(&frame, DAVAR_CAN_BASE, &decoded) == DAVAR_DECODE_FOREIGN,
           davar_telemetry_init(&telemetry, &davar_cyphal, &nobody, 100.0),
           (int)davar_slcan_encode(&frame, text), (unsigned)davar_torn_reads(&torn),
           (unsigned)davar_small_health(&small).missed, davar_rate_density(0.3, DAVAR_DEG_PER_S));
    return 0;
}
