/* davar on a bare board - the mps2 and mps3 boards: the FPGA's counter of cycles as a clock, first UART. */
#include "board.h"
#include "registers.h"

#define CYCLES REGISTER(BOARD_TIMER + 0x18U) /* of the FPGA, from reset on */
#define UART_DATA REGISTER(BOARD_UART + 0x0U)
#define UART_STATE REGISTER(BOARD_UART + 0x4U)
#define UART_CONTROL REGISTER(BOARD_UART + 0x8U)
#define UART_DIVIDER REGISTER(BOARD_UART + 0x10U)

#define ENABLE 1U
#define TRANSMITTER_FULL 1U
#define BAUD 1000000U

uint32_t board_clock(void)
{
    return CYCLES;
}

bool board_serial_put(char character)
{
    if ((UART_CONTROL & ENABLE) == 0U) {
        UART_DIVIDER = (BOARD_CLOCK_PER_US * 1000000U) / BAUD;
        UART_CONTROL = ENABLE;
    }
    if ((UART_STATE & TRANSMITTER_FULL) != 0U) {
        return false;
    }
    UART_DATA = (uint8_t)character;
    return true;
}
