/* davar on a bare board - the microbit (nRF51): TIMER0 as a clock, the UART. */
#include "board.h"
#include "registers.h"

#define TIMER 0x40008000U
#define TIMER_START REGISTER(TIMER + 0x0U)
#define TIMER_CAPTURE REGISTER(TIMER + 0x40U)
#define TIMER_BITS REGISTER(TIMER + 0x508U)
#define TIMER_PRESCALER REGISTER(TIMER + 0x510U)
#define TIMER_CAPTURED REGISTER(TIMER + 0x540U)
#define UART 0x40002000U
#define UART_START REGISTER(UART + 0x8U)
#define UART_SENT REGISTER(UART + 0x11CU)
#define UART_ENABLE REGISTER(UART + 0x500U)
#define UART_DATA REGISTER(UART + 0x51CU)

#define BITS_32 3U
#define ON 4U

uint32_t board_clock(void)
{
    if (TIMER_BITS != BITS_32) {
        TIMER_BITS = BITS_32;
        TIMER_PRESCALER = 0U;
        TIMER_START = 1U;
    }
    TIMER_CAPTURE = 1U;
    return TIMER_CAPTURED;
}

bool board_serial_put(char character)
{
    if (UART_ENABLE != ON) {
        UART_ENABLE = ON;
        UART_START = 1U;
    } else if (UART_SENT == 0U) {
        return false;
    }
    UART_SENT = 0U;
    UART_DATA = (uint8_t)character;
    return true;
}
