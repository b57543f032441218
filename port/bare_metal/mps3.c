/* davar on a bare board - the mps3 boards: the system counter of their SSE-300 as a clock, first
 * UART. */
#include "board.h"
#include "registers.h"

#define COUNTER_CONTROL REGISTER(BOARD_TIMER + 0x0U)
#define COUNTER_VALUE REGISTER(BOARD_TIMER + 0x8U) /* low word */
#define UART_DATA REGISTER(BOARD_UART + 0x0U)
#define UART_STATE REGISTER(BOARD_UART + 0x4U)
#define UART_CONTROL REGISTER(BOARD_UART + 0x8U)
#define UART_DIVIDER REGISTER(BOARD_UART + 0x10U)

#define ENABLE 1U
#define TRANSMITTER_FULL 1U
#define BAUD 1000000U

uint32_t board_clock(void)
{
    if ((COUNTER_CONTROL & ENABLE) == 0U) {
        COUNTER_CONTROL = ENABLE;
    }
    return COUNTER_VALUE;
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
