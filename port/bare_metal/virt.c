/* davar on a bare board - the RISC-V virt board: the machine timer as a clock, its 16550 UART. */
#include "board.h"
#include "registers.h"

#define MACHINE_TIME 0x0200BFF8U /* low word */
#define UART 0x10000000U

#define UART_BYTE(offset) (*(volatile uint8_t *)(UART + (offset)))
#define LINE_STATUS 5U
#define TRANSMITTER_EMPTY 0x20U

uint32_t board_clock(void)
{
    return REGISTER(MACHINE_TIME);
}

bool board_serial_put(char character)
{
    if ((UART_BYTE(LINE_STATUS) & TRANSMITTER_EMPTY) == 0U) {
        return false;
    }
    UART_BYTE(0U) = (uint8_t)character;
    return true;
}
