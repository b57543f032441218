/* Sends the results of one channel on the chip's CAN controller: see can_sender.c. */
#ifndef CAN_SENDER_H
#define CAN_SENDER_H

#include "davar/can.h"

/* Gives the controller a frame: bxcan_send or fdcan_send with a cast of the controller. False: no
 * room now. */
typedef bool (*can_send_t)(void *controller, const davar_frame_t *frame);

/* `config` is the configuration of the instance. `session` must differ at each start (a boot
 * counter). fd: one frame of 64 bytes per result. False: the identifiers exceed 11 bits. */
bool can_sender_start(const davar_config_t *config, uint8_t session, bool fd, can_send_t send,
                      void *controller);

/* Sends a new result with the counters of its instance. Unsent frames of the previous result are
 * dropped and counted. For the changes of law glr, give davar_encoder_begin a report
 * (davar/glr.h). */
void can_sender_result(const davar_result_t *result, const davar_health_t *health,
                       uint32_t bus_off);

/* Call it often from the main loop: gives the controller the next frame if there is room. Never
 * waits. */
void can_sender_step(void);

#endif
