/* The calls of examples/betaflight, placed by the linker (-Wl,--wrap) because the source of
 * Betaflight is not changed here. A user writes them into the firmware. */
#include "davar_gyro.h"

#include "platform.h"

#include "common/time.h"
#include "msp/msp_serial.h"
#include "sensors/gyro.h"

void __real_gyroUpdate(void);
void __wrap_gyroUpdate(void);
void __real_mspSerialProcess(mspEvaluateNonMspData_e evaluate, mspProcessCommandFnPtr command,
                             mspProcessReplyFnPtr reply);
void __wrap_mspSerialProcess(mspEvaluateNonMspData_e evaluate, mspProcessCommandFnPtr command,
                             mspProcessReplyFnPtr reply);

void __wrap_gyroUpdate(void)
{
    __real_gyroUpdate();
    davar_gyro_sample();
}

/* The last call of taskHandleSerial. */
void __wrap_mspSerialProcess(mspEvaluateNonMspData_e evaluate, mspProcessCommandFnPtr command,
                             mspProcessReplyFnPtr reply)
{
    __real_mspSerialProcess(evaluate, command, reply);
    davar_gyro_task();
}

#ifdef USE_TELEMETRY_MAVLINK
void __real_handleMAVLinkTelemetry(void);
void __wrap_handleMAVLinkTelemetry(void);

void __wrap_handleMAVLinkTelemetry(void)
{
    __real_handleMAVLinkTelemetry();
    davar_gyro_mavlink();
}
#endif
