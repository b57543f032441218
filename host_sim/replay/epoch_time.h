/* davar-sim - the time stamp of an epoch. */
#ifndef EPOCH_TIME_H
#define EPOCH_TIME_H

#include "recording/recording.h"

#define EPOCH_TIME_CACHE 1024U

typedef struct {
    const recording_t *recording;
    double rate_hz;
    uint64_t first; /* row of the first cached stamp */
    size_t count;
    double time_s[EPOCH_TIME_CACHE];
} epoch_time_t;

/* If the recording has no time stamps, the time of an epoch is epoch / rate_hz. */
void epoch_time_open(epoch_time_t *epoch_time, const recording_t *recording, double rate_hz);

/* Epochs may come in any order; ascending order is fast. `epoch` is a row of the recording. */
bool epoch_time_find(epoch_time_t *epoch_time, uint64_t epoch, double *time_s, sim_error_t *error);

#endif
