/* Sends on the bxCAN of an STM32 (F0, F1, F3, F4, F7, L4): see bxcan.c. */
#ifndef BXCAN_H
#define BXCAN_H

#include "davar/can.h"

/* Its registers, RM0090 32.9. Registers that sending does not need have no name. */
typedef volatile struct {
    uint32_t MCR;
    uint32_t MSR;
    uint32_t TSR;
    uint32_t receiving[3];
    uint32_t ESR;
    uint32_t BTR;
    uint32_t unused[88];
    struct {
        uint32_t TIR;
        uint32_t TDTR;
        uint32_t TDLR;
        uint32_t TDHR;
    } mailbox[3];
} bxcan_registers_t;

typedef struct {
    bxcan_registers_t *registers; /* (bxcan_registers_t *)0x40006400 is CAN1 of an F4 */
    uint32_t timing;              /* BTR: bxcan_timing() */
    bool is_running;
    bool is_off;
    uint32_t bus_off; /* number of times */
} bxcan_t;

/* BTR for a bit of 1 + segment1 + segment2 quanta of `divider` clocks each. */
uint32_t bxcan_timing(uint32_t divider, uint32_t segment1, uint32_t segment2);

/* Requests initialisation of the controller. Clock and pins must be enabled already. */
void bxcan_start(bxcan_t *can, bxcan_registers_t *registers, uint32_t timing);

/* Call it often from the main loop: ends the initialisation and counts bus-off events. Never
 * waits. */
void bxcan_poll(bxcan_t *can);

/* False: no room now, or no bus; try again. Frames are sent in the order of the calls. */
bool bxcan_send(bxcan_t *can, const davar_frame_t *frame);

#endif
