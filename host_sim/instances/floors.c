/* davar-sim - floors. */
#include "instances/floors.h"

#include <stdlib.h>

bool floors_open(floors_t *floors, const options_t *options, const engine_t *engine,
                 const char *const *names, sim_error_t *error)
{
    if (!options->floor) {
        return true;
    }
    if (engine->number == DAVAR_PORT_F32) {
        return sim_fail(error, "--floor: needs counts: give --lsb, without --arith float");
    }
    floors->count = engine->count;
    floors->number = engine->number;
    floors->plans = calloc(engine->count, sizeof *floors->plans);
    floors->channels = calloc(engine->count, sizeof *floors->channels);
    if ((floors->plans == NULL) || (floors->channels == NULL)) {
        return sim_fail(error, "out of memory");
    }
    for (size_t c = 0; c < engine->count; c++) {
        if (!setup_floor(&engine->filtered[c].config, engine->number, engine->filters[c], names[c],
                         &floors->plans[c], error)) {
            return false;
        }
        davar_floor_start(&floors->channels[c].floor);
        davar_floor_take(&floors->channels[c].floor, &floors->plans[c],
                         &floors->channels[c].newest);
    }
    return true;
}

/* Takes the result that is due. False: out of memory. */
static bool keep(floor_channel_t *channel, const davar_floor_plan_t *plan)
{
    if (channel->count == channel->room) {
        const size_t room = 2U * channel->room + 16U;
        floor_at_t *const waiting = realloc(channel->waiting, room * sizeof *waiting);
        if (waiting == NULL) {
            return false;
        }
        channel->waiting = waiting;
        channel->room = room;
    }
    floor_at_t *const at = &channel->waiting[channel->count];
    at->samples = channel->samples;
    davar_floor_take(&channel->floor, plan, &at->result);
    channel->count++;
    return true;
}

bool floors_push(floors_t *floors, const davar_port_samples_t *samples, size_t count, bool is_gap,
                 sim_error_t *error)
{
    for (size_t c = 0; (floors->plans != NULL) && (c < floors->count); c++) {
        floor_channel_t *const channel = &floors->channels[c];
        if (is_gap) {
            davar_floor_gap(&channel->floor);
        }
        for (size_t i = 0; i < count; i++) {
            const int32_t sample =
                (floors->number == DAVAR_PORT_Q15) ? samples[c].q15[i] : samples[c].q31[i];
            channel->samples++;
            if (davar_floor_push(&channel->floor, &floors->plans[c], sample) &&
                !keep(channel, &floors->plans[c])) {
                return sim_fail(error, "--floor: out of memory");
            }
        }
    }
    return true;
}

const davar_floor_result_t *floors_at(floors_t *floors, size_t channel, uint64_t epoch)
{
    size_t done = 0;
    if (floors->plans == NULL) {
        return NULL;
    }
    floor_channel_t *const of = &floors->channels[channel];
    while ((done < of->count) && (of->waiting[done].samples <= epoch + 1U)) {
        of->newest = of->waiting[done].result;
        done++;
    }
    of->count -= done;
    for (size_t i = 0; (done > 0U) && (i < of->count); i++) {
        of->waiting[i] = of->waiting[i + done];
    }
    return &of->newest;
}

void floors_close(floors_t *floors)
{
    for (size_t c = 0; (floors->channels != NULL) && (c < floors->count); c++) {
        free(floors->channels[c].waiting);
    }
    free(floors->channels);
    free(floors->plans);
    *floors = (floors_t){0};
}
