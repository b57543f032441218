/* davar-sim - epoch times: read from the spool, one page at a time. */
#include "replay/epoch_time.h"

void epoch_time_open(epoch_time_t *epoch_time, const recording_t *recording, double rate_hz)
{
    epoch_time->recording = recording;
    epoch_time->rate_hz = rate_hz;
    epoch_time->first = 0;
    epoch_time->count = 0;
}

static bool load(epoch_time_t *epoch_time, uint64_t epoch, sim_error_t *error)
{
    const uint64_t left = epoch_time->recording->rows - epoch;
    epoch_time->first = epoch;
    epoch_time->count = (left < EPOCH_TIME_CACHE) ? (size_t)left : EPOCH_TIME_CACHE;
    return spool_read(&epoch_time->recording->times, epoch, epoch_time->count, epoch_time->time_s,
                      error);
}

bool epoch_time_find(epoch_time_t *epoch_time, uint64_t epoch, double *time_s, sim_error_t *error)
{
    if (!epoch_time->recording->has_time) {
        *time_s = (double)epoch / epoch_time->rate_hz;
        return true;
    }
    const bool cached =
        (epoch >= epoch_time->first) && (epoch - epoch_time->first < epoch_time->count);
    if (!cached && !load(epoch_time, epoch, error)) {
        return false;
    }
    *time_s = epoch_time->time_s[epoch - epoch_time->first];
    return true;
}
