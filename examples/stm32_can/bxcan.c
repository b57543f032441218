/* Sends davar's frames on the chip's own CAN controller: bxCAN, after RM0090
 * (STM32F405/407/427/429) chapter 32.
 *
 * The three mailboxes are sent in the order of the requests (TXFP), because the frames of a result
 * must stay in order. After bus-off the controller recovers by itself (ABOM) after 128 times 11
 * recessive bits. Nothing waits: a frame without room is sent at the next call.
 *
 * For your board: enable clock and pins of the controller, and set its base address and the timing
 * for your clock. At 42 MHz and 500 kbit/s use bxcan_timing(6, 11, 2): 14 quanta, sample point at
 * 86 %.
 *
 * This file has not run on a chip. Its test places the registers in memory and simulates the
 * controller after the manual. */
#include "bxcan.h"

#define MCR_INRQ (UINT32_C(1) << 0)
#define MCR_TXFP (UINT32_C(1) << 2)
#define MCR_ABOM (UINT32_C(1) << 6)
#define MSR_INAK (UINT32_C(1) << 0)
#define TSR_CODE 24U /* the next empty mailbox */
#define TSR_TME (UINT32_C(7) << 26)
#define ESR_BOFF (UINT32_C(1) << 2)
#define TIR_TXRQ (UINT32_C(1) << 0)
#define TIR_STID 21U

_Static_assert((offsetof(bxcan_registers_t, ESR) == 0x18) &&
                   (offsetof(bxcan_registers_t, mailbox) == 0x180),
               "RM0090 32.9");

uint32_t bxcan_timing(uint32_t divider, uint32_t segment1, uint32_t segment2)
{
    return (divider - 1U) | ((segment1 - 1U) << 16U) | ((segment2 - 1U) << 20U);
}

void bxcan_start(bxcan_t *can, bxcan_registers_t *registers, uint32_t timing)
{
    *can = (bxcan_t){.registers = registers, .timing = timing};
    registers->MCR =
        MCR_INRQ | MCR_TXFP | MCR_ABOM; /* and leaves SLEEP, which is set after a reset */
}

void bxcan_poll(bxcan_t *can)
{
    bxcan_registers_t *const registers = can->registers;
    const bool initialises = (registers->MSR & MSR_INAK) != 0U;
    const bool asked = (registers->MCR & MCR_INRQ) != 0U;
    if (asked && initialises) {
        registers->BTR = can->timing;
        registers->MCR = MCR_TXFP | MCR_ABOM; /* it joins the bus after 11 recessive bits */
    }
    can->is_running = !asked && !initialises;
    const bool is_off = (registers->ESR & ESR_BOFF) != 0U;
    can->bus_off += (is_off && !can->is_off) ? 1U : 0U;
    can->is_off = is_off;
}

static uint32_t word_of(const uint8_t *data)
{
    return data[0] | ((uint32_t)data[1] << 8U) | ((uint32_t)data[2] << 16U) |
           ((uint32_t)data[3] << 24U);
}

bool bxcan_send(bxcan_t *can, const davar_frame_t *frame)
{
    bxcan_registers_t *const registers = can->registers;
    const uint32_t status = registers->TSR;
    if (!can->is_running || can->is_off || ((status & TSR_TME) == 0U) || (frame->length > 8U)) {
        return false;
    }
    const uint32_t box = (status >> TSR_CODE) & 3U;
    registers->mailbox[box].TDTR = frame->length;
    registers->mailbox[box].TDLR = word_of(&frame->data[0]);
    registers->mailbox[box].TDHR = word_of(&frame->data[4]);
    registers->mailbox[box].TIR = ((uint32_t)frame->identifier << TIR_STID) | TIR_TXRQ;
    return true;
}
