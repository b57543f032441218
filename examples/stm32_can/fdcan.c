/* Sends davar's frames on the chip's own CAN controller: FDCAN, after RM0440 (STM32G4) chapter 44.
 * The FDCAN of the H7 and U5 has more buffers and the same registers for sending, but the user
 * defines the layout of its message RAM.
 *
 * Three buffers work as a FIFO, so frames are sent in order. DAVAR_ResultFd is sent as CAN FD with
 * the faster bit rate for its data, all others as classical frames. At bus-off the controller sets
 * INIT itself. Clearing it makes the controller rejoin the bus after 128 times 11 recessive bits.
 * Nothing waits: a frame without room is sent at the next call.
 *
 * For your board: enable clock and pins of the controller, and set the addresses and the timings
 * for your clock. At 80 MHz fdcan_timing(10, 13, 2) is 500 kbit/s with the sample point at 88 %,
 * and fdcan_data_timing(2, 15, 4) is 2 Mbit/s.
 *
 * This file has not run on a chip. Its test places the registers in memory and simulates the
 * controller after the manual. */
#include "fdcan.h"

#define CCCR_INIT (UINT32_C(1) << 0)
#define CCCR_CCE (UINT32_C(1) << 1)
#define CCCR_FDOE (UINT32_C(1) << 8)
#define CCCR_BRSE (UINT32_C(1) << 9)
#define PSR_BO (UINT32_C(1) << 7)
#define TXFQS_PUT 16U
#define TXFQS_FULL (UINT32_C(1) << 21)
#define ELEMENT_ID 18U
#define ELEMENT_DLC 16U
#define ELEMENT_FD (UINT32_C(3) << 20) /* FDF and BRS */
#define DLC_OF_64 15U

_Static_assert((offsetof(fdcan_registers_t, CCCR) == 0x18) &&
                   (offsetof(fdcan_registers_t, PSR) == 0x44) &&
                   (offsetof(fdcan_registers_t, TXBC) == 0xC0) &&
                   (offsetof(fdcan_registers_t, TXBAR) == 0xCC),
               "RM0440 44.4");

uint32_t fdcan_timing(uint32_t divider, uint32_t segment1, uint32_t segment2)
{
    return ((segment2 - 1U) << 25U) | ((divider - 1U) << 16U) | ((segment1 - 1U) << 8U) |
           (segment2 - 1U);
}

uint32_t fdcan_data_timing(uint32_t divider, uint32_t segment1, uint32_t segment2)
{
    return ((divider - 1U) << 16U) | ((segment1 - 1U) << 8U) | ((segment2 - 1U) << 4U) |
           (segment2 - 1U);
}

void fdcan_start(fdcan_t *can)
{
    can->is_running = false;
    can->registers->CCCR = CCCR_INIT;
}

void fdcan_poll(fdcan_t *can)
{
    fdcan_registers_t *const registers = can->registers;
    const uint32_t control = registers->CCCR;
    const bool is_off = (registers->PSR & PSR_BO) != 0U;
    can->bus_off += (is_off && !can->is_off) ? 1U : 0U;
    can->is_off = is_off;
    if ((control & CCCR_INIT) == 0U) {
        can->is_running = true;
    } else if (can->is_running) {
        can->is_running = false; /* bus-off: rejoin the bus; the settings remain */
        registers->CCCR = control & ~CCCR_INIT;
    } else if ((control & CCCR_CCE) == 0U) {
        registers->CCCR = CCCR_INIT | CCCR_CCE;
    } else {
        registers->NBTP = can->nominal;
        registers->DBTP = can->data;
        registers->TXBC = 0U; /* a FIFO */
        registers->CCCR = CCCR_INIT | CCCR_CCE | CCCR_FDOE | CCCR_BRSE;
        registers->CCCR = CCCR_FDOE | CCCR_BRSE; /* it joins the bus after 11 recessive bits */
    }
}

static uint32_t word_of(const uint8_t *data)
{
    return data[0] | ((uint32_t)data[1] << 8U) | ((uint32_t)data[2] << 16U) |
           ((uint32_t)data[3] << 24U);
}

bool fdcan_send(fdcan_t *can, const davar_frame_t *frame)
{
    const uint32_t status = can->registers->TXFQS;
    const bool is_fd = (frame->length == 64U);
    if (!can->is_running || can->is_off || ((status & TXFQS_FULL) != 0U) ||
        (!is_fd && (frame->length > 8U))) {
        return false;
    }
    const uint32_t put = (status >> TXFQS_PUT) & 3U;
    fdcan_buffer_t *const buffer = &can->buffers[put];
    buffer->word[0] = (uint32_t)frame->identifier << ELEMENT_ID;
    buffer->word[1] =
        ((is_fd ? DLC_OF_64 : frame->length) << ELEMENT_DLC) | (is_fd ? ELEMENT_FD : 0U);
    for (uint32_t i = 0U; i < ((frame->length + 3U) / 4U); i++) {
        buffer->word[2U + i] = word_of(&frame->data[4U * i]);
    }
    can->registers->TXBAR = UINT32_C(1) << put;
    return true;
}
