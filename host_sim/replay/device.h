/* davar-sim - pass 2 on a device: the recording goes out as a job, a command runs the device, its results come in. */
#ifndef DEVICE_H
#define DEVICE_H

#include "instances/engine.h"
#include "replay/replay.h"

/* Writes the job that `replay` would feed to `engine`, runs "COMMAND JOB RESULTS" (files of its own, removed again), and
 * sends what the device found through the replay's port; *health is the weather that the device met. False: the error
 * names the command or the file. */
bool device_replay(const char *command, replay_t *replay, const engine_t *engine,
                   davar_health_t *health, sim_error_t *error);

#endif
