/* davar-sim - one floor per channel (davar/floor.h), for --floor. */
#ifndef FLOORS_H
#define FLOORS_H

#include "davar/floor.h"
#include "instances/engine.h"

/* A result, and how many samples the channel had then. */
typedef struct {
    uint64_t samples;
    davar_floor_result_t result;
} floor_at_t;

typedef struct {
    davar_floor_t floor;
    uint64_t samples;
    floor_at_t *waiting; /* newer than what was asked for; in order */
    size_t count;
    size_t room;
    davar_floor_result_t newest; /* up to what was asked for */
} floor_channel_t;

typedef struct {
    davar_floor_plan_t *plans; /* one per channel; null: no --floor */
    floor_channel_t *channels;
    size_t count;
    davar_port_number_t number;
} floors_t;

/* Does nothing without --floor. names: of the channels. False: a channel whose filter is unknown,
 * no plan for the recording, or out of memory. */
bool floors_open(floors_t *floors, const options_t *options, const engine_t *engine,
                 const char *const *names, sim_error_t *error);

/* Adds samples of all channels, after a gap if some are missing. False: out of memory. */
bool floors_push(floors_t *floors, const davar_port_samples_t *samples, size_t count, bool is_gap,
                 sim_error_t *error);

/* The newest result of a channel when it had its sample number `epoch`, or null without --floor.
 * Epochs do not go back. Valid until the next call. */
const davar_floor_result_t *floors_at(floors_t *floors, size_t channel, uint64_t epoch);

/* Allowed if all zero. */
void floors_close(floors_t *floors);

#endif
