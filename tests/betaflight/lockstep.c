/* Betaflight's SITL on a virtual clock. Each gyro period takes one sample from a file, so that a
 * flight does not depend on the speed or the load of the machine.
 *
 * LOCKSTEP_COUNTS  int16 x y z of each period, in counts. Without it the gyro reads 0, and a client
 *                  of the CLI can set the firmware up.
 * LOCKSTEP_MOTORS  file for the four motor outputs of each period (float). The craft is armed.
 * LOCKSTEP_PACE    periods between two requests of MSP_DEBUG: the clock waits for each of them.
 *
 * Without LOCKSTEP_PACE the program ends with the file. With it, it goes on answering clients. */
#include "platform.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "common/axis.h"
#include "common/time.h"
#include "drivers/accgyro/accgyro_virtual.h"
#include "dyad.h"
#include "fc/runtime_config.h"
#include "flight/mixer.h"
#include "msp/msp.h"
#include "msp/msp_protocol.h"
#include "msp/msp_serial.h"
#include "sensors/gyro.h"

#define SETTLE 16000U        /* periods until the craft is armed: the gyro is calibrated by then */
#define THROTTLE_UPDATE 40U  /* periods, as in Betaflight's mixer */
#define THROTTLE_RISE 16000U /* ... from 0 to full throttle */

static uint64_t now_us = 1000;
static bool running; /* start-up is over */
static uint32_t requests;
static FILE *counts, *motors;
static uint32_t pace;

/* --- the clock --- */

uint32_t __wrap_micros(void);
uint32_t __wrap_millis(void);
uint32_t __wrap_getCycleCounter(void);
void __wrap_delayMicroseconds_real(uint32_t us);

uint32_t __wrap_micros(void)
{
    now_us += running ? 0U : 1U; /* start-up waits for it */
    return (uint32_t)now_us;
}

uint32_t __wrap_millis(void)
{
    now_us += running ? 0U : 50U;
    return (uint32_t)(now_us / 1000U);
}

uint32_t __wrap_getCycleCounter(void)
{
    return (uint32_t)++now_us; /* the scheduler waits for it; SITL has 1 MHz */
}

/* After every pass of the scheduler. */
void __wrap_delayMicroseconds_real(uint32_t us)
{
    UNUSED(us);
    running = true;
    now_us += 25U;
}

/* --- clients --- */

void __real_dyad_setUpdateTimeout(double seconds);
void __wrap_dyad_setUpdateTimeout(double seconds);
void __real_dyad_update(void);
void __wrap_dyad_update(void);
mspResult_e __real_mspFcProcessCommand(mspDescriptor_t source, mspPacket_t *command,
                                       mspPacket_t *reply, mspPostProcessFnPtr *after);
mspResult_e __wrap_mspFcProcessCommand(mspDescriptor_t source, mspPacket_t *command,
                                       mspPacket_t *reply, mspPostProcessFnPtr *after);

void __wrap_dyad_setUpdateTimeout(double seconds)
{
    UNUSED(seconds);
    __real_dyad_setUpdateTimeout(0.0);
}

/* For SITL's own thread. The firmware writes to the sockets without a lock, so they are served
 * between two periods instead. */
void __wrap_dyad_update(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
}

mspResult_e __wrap_mspFcProcessCommand(mspDescriptor_t source, mspPacket_t *command,
                                       mspPacket_t *reply, mspPostProcessFnPtr *after)
{
    requests += (command->cmd == MSP_DEBUG) ? 1U : 0U;
    return __real_mspFcProcessCommand(source, command, reply, after);
}

static void wait_for_request(void)
{
    for (const uint32_t before = requests; requests == before;) {
        __real_dyad_update();
        mspSerialProcess(MSP_SKIP_NON_MSP_DATA, __wrap_mspFcProcessCommand, NULL);
    }
    __real_dyad_update(); /* sends the reply */
}

/* --- the throttle, as the dynamic low-pass sees it: up and down all the time --- */

void __real_dynLpfGyroUpdate(float throttle);
void __wrap_dynLpfGyroUpdate(float throttle);

void __wrap_dynLpfGyroUpdate(float throttle)
{
    UNUSED(throttle); /* the mixer's: no transmitter moves it */
}

static void move_throttle(uint32_t periods)
{
    if (periods % THROTTLE_UPDATE == 0U) {
        const float phase = (float)(periods % (2U * THROTTLE_RISE)) / (float)THROTTLE_RISE;
        __real_dynLpfGyroUpdate((phase < 1.0f) ? phase : (2.0f - phase));
    }
}

/* --- a period --- */

void __real_taskGyroSample(timeUs_t us);
void __wrap_taskGyroSample(timeUs_t us);

static FILE *file(const char *variable, const char *mode)
{
    const char *path = getenv(variable);
    return (path != NULL) ? fopen(path, mode) : NULL;
}

static void open_files(void)
{
    counts = file("LOCKSTEP_COUNTS", "rb");
    motors = file("LOCKSTEP_MOTORS", "wb");
    const char *periods = getenv("LOCKSTEP_PACE");
    pace = (periods != NULL) ? (uint32_t)strtoul(periods, NULL, 10) : 0U;
}

void __wrap_taskGyroSample(timeUs_t us)
{
    static uint32_t periods;
    int16_t xyz[XYZ_AXIS_COUNT] = {0};
    if (periods == 0U) {
        open_files();
    }
    if ((counts != NULL) && (fread(xyz, sizeof xyz, 1, counts) != 1U) && (pace == 0U)) {
        exit(motors != NULL ? fclose(motors) : 0);
    }
    if ((pace != 0U) && (periods % pace == 0U)) {
        wait_for_request(); /* the only place: no request is answered while the clock runs */
    } else if ((counts == NULL) && (periods % 80U == 0U)) {
        __real_dyad_update();
    }
    if (motors != NULL) {
        fwrite(motor, sizeof motor[0], 4, motors);
        if (periods >= SETTLE) {
            ENABLE_ARMING_FLAG(ARMED);
        }
    }
    move_throttle(periods);
    periods++;
    virtualGyroSet(virtualGyroDev, xyz[X], xyz[Y], xyz[Z]);
    __real_taskGyroSample(us);
}
