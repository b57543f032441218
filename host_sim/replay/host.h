/* davar-sim - pass 2 with centred windows, which only the host computes. */
#ifndef HOST_H
#define HOST_H

#include "instances/engine.h"
#include "replay/replay.h"

/* Pushes the recording to the centred instances of the engine, and sends every result through the
 * replay's port, in the order of the node loop (port/node): epoch by epoch, and the channels of an
 * epoch in order. False: the port has failed; the replay's error has the message. */
bool host_replay(replay_t *replay, engine_t *engine);

#endif
