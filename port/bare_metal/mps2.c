/* davar on a bare board - the mps2 boards: first timer as a clock, first UART. */
#include "board.h"
#include "registers.h"

#define TIMER_CONTROL REGISTER(BOARD_TIMER + 0x0U)
#define TIMER_VALUE REGISTER(BOARD_TIMER + 0x4U)
#define TIMER_RELOAD REGISTER(BOARD_TIMER + 0x8U)
#define UART_DATA REGISTER(BOARD_UART + 0x0U)
#define UART_STATE REGISTER(BOARD_UART + 0x4U)
#define UART_CONTROL REGISTER(BOARD_UART + 0x8U)
#define UART_DIVIDER REGISTER(BOARD_UART + 0x10U)

#define ENABLE 1U
#define TRANSMITTER_FULL 1U
#define BAUD 1000000U

uint32_t board_clock(void)
{
    if ((TIMER_CONTROL & ENABLE) == 0U) {
        TIMER_RELOAD = UINT32_MAX;
        TIMER_VALUE = UINT32_MAX;
        TIMER_CONTROL = ENABLE;
    }
    return UINT32_MAX - TIMER_VALUE;
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
