/* Results of one channel on the chip's CAN controller: see can_sender.c. */
#ifndef CAN_SENDER_H
#define CAN_SENDER_H

#include "davar/wire.h"

/* How the controller takes a frame: bxcan_send or fdcan_send behind a cast of its own. False: no room now. */
typedef bool (*can_send_t)(void *controller, const davar_frame_t *frame);

/* `config` is that of the instance; `session` another number at each start (a boot counter); fd: one frame of 64 bytes a result. */
void can_sender_start(const davar_config_t *config, uint8_t session, bool fd, can_send_t send,
                      void *controller);

/* A new result, with what its instance has counted. Frames of the one before that have not left are dropped, and counted. */
void can_sender_result(const davar_result_t *result, const davar_health_t *health,
                       uint32_t bus_off);

/* Often, from the main loop: gives the controller the next frame, if it has room. Never waits. */
void can_sender_step(void);

#endif
