/* davar-sim - pass 2 on a device: writes the recording as a job, runs a command, reads the
 * results. */
#ifndef DEVICE_H
#define DEVICE_H

#include "instances/engine.h"
#include "replay/replay.h"

/* Writes the job that `replay` would feed to `engine` and runs "COMMAND JOB RESULTS". The two files
 * are temporary. Sends the device's results through the replay's port; *health has the device's
 * counters. False: the error names the command or the file. */
bool device_replay(const char *command, replay_t *replay, const engine_t *engine,
                   davar_health_t *health, sim_error_t *error);

#endif
