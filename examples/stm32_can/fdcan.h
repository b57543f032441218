/* Sends on the FDCAN of an STM32G4: see fdcan.c. */
#ifndef FDCAN_H
#define FDCAN_H

#include "davar/can.h"

/* Its registers, RM0440 44.4. Registers that sending does not need have no name. */
typedef volatile struct {
    uint32_t identity[3];
    uint32_t DBTP; /* 0x00C */
    uint32_t unused[2];
    uint32_t CCCR; /* 0x018 */
    uint32_t NBTP;
    uint32_t unused_too[9];
    uint32_t PSR; /* 0x044 */
    uint32_t receiving[30];
    uint32_t TXBC;  /* 0x0C0 */
    uint32_t TXFQS; /* 0x0C4 */
    uint32_t TXBRP;
    uint32_t TXBAR; /* 0x0CC */
} fdcan_registers_t;

/* One buffer of the message RAM: identifier, length, 64 bytes. */
typedef volatile struct {
    uint32_t word[18];
} fdcan_buffer_t;

typedef struct {
    fdcan_registers_t *registers; /* (fdcan_registers_t *)0x40006400 is FDCAN1 of a G4 */
    fdcan_buffer_t *buffers;      /* its three buffers: (fdcan_buffer_t *)(0x4000A400 + 0x278) */
    uint32_t nominal;             /* NBTP, fdcan_timing() */
    uint32_t data;                /* DBTP, fdcan_data_timing() */
    bool is_running;
    bool is_off;
    uint32_t bus_off; /* number of times */
} fdcan_t;

/* NBTP and DBTP for bits of 1 + segment1 + segment2 quanta of `divider` clocks each. */
uint32_t fdcan_timing(uint32_t divider, uint32_t segment1, uint32_t segment2);
uint32_t fdcan_data_timing(uint32_t divider, uint32_t segment1, uint32_t segment2);

/* Requests initialisation of the controller. Set registers, buffers, nominal and data before. Clock
 * and pins must be enabled already. */
void fdcan_start(fdcan_t *can);

/* Call it often from the main loop: ends the initialisation, counts bus-off events and rejoins the
 * bus. Never waits. */
void fdcan_poll(fdcan_t *can);

/* False: no room now, or no bus; try again. Frames are sent in the order of the calls, a frame of
 * 64 bytes as CAN FD. */
bool fdcan_send(fdcan_t *can, const davar_frame_t *frame);

#endif
