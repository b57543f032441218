/* davar on a bare board - start-up, FPU and SysTick of a Cortex-M. The vector table is at the start
 * of flash. It uses only reset, faults and SysTick. */
#include "board.h"
#include "registers.h"
#include "semihosting.h"

#include <string.h>

/* From cortex_m.ld; only their addresses have a meaning. */
extern uint32_t image_data_load;
extern uint32_t image_data_start;
extern uint32_t image_data_end;
extern uint32_t image_bss_start;
extern uint32_t image_bss_end;
extern uint32_t image_stack_top;

int main(void);
void board_reset(void);
void board_fault(void);
void board_tick(void);

#define SYSTICK_CONTROL REGISTER(0xE000E010U)
#define SYSTICK_RELOAD REGISTER(0xE000E014U)
#define SYSTICK_VALUE REGISTER(0xE000E018U)
#define COPROCESSOR_ACCESS REGISTER(0xE000ED88U)
#define SYSTICK_MASK 0xFFFFFFU

intptr_t semihosting_call(int operation, const void *parameters)
{
    register intptr_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = parameters;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_start(void)
{
#if defined(__ARM_FP)
    COPROCESSOR_ACCESS = COPROCESSOR_ACCESS | (0xFU << 20U);
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
    SYSTICK_RELOAD = SYSTICK_MASK;
    SYSTICK_VALUE = 0U;
    SYSTICK_CONTROL = 5U; /* processor clock, no interrupt */
}

uint32_t board_mark(void)
{
    return SYSTICK_VALUE;
}

void board_tick_every(uint32_t microseconds)
{
    SYSTICK_RELOAD = (microseconds * BOARD_CLOCK_PER_US) - 1U;
    SYSTICK_VALUE = 0U;
    SYSTICK_CONTROL = 7U; /* processor clock, interrupt */
}

/* One instruction takes 2^8 ns of the emulator's time, one tick takes 1 / BOARD_CLOCK_PER_US us. */
uint32_t board_instructions_since(uint32_t mark)
{
    const uint64_t ticks = (mark - SYSTICK_VALUE) & SYSTICK_MASK;
    return (uint32_t)(((ticks * 1000U) + (128U * BOARD_CLOCK_PER_US)) /
                      (256U * BOARD_CLOCK_PER_US));
}

void board_fault(void)
{
    board_text("fault\n");
    board_exit(99);
}

__attribute__((weak)) void board_tick(void) {}

void board_reset(void)
{
    memcpy(&image_data_start, &image_data_load,
           (size_t)((uintptr_t)&image_data_end - (uintptr_t)&image_data_start));
    memset(&image_bss_start, 0, (size_t)((uintptr_t)&image_bss_end - (uintptr_t)&image_bss_start));
    board_start();
    board_exit(main());
}

typedef void (*handler_t)(void);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack_top;
    handler_t handler[15];
} vectors = {
    &image_stack_top,
    {board_reset, board_fault, board_fault, board_fault, board_fault, board_fault, 0, 0, 0, 0,
     board_fault, board_fault, 0, board_fault, board_tick},
};
