/* davar on a bare board - RISC-V: the counter of retired instructions, and semihosting by its magic
 * sequence. */
#include "board.h"
#include "registers.h"
#include "semihosting.h"

#include <string.h>

extern uint32_t image_bss_start;
extern uint32_t image_bss_end;

int main(void);
void board_begin(void);
void board_reset(void);
void board_trap(void);

#define MACHINE_TIME_COMPARE 0x02004000U /* of the first core; low word, then high */
#define TIMER_INTERRUPT 0x80U            /* in mie */
#define INTERRUPTS 8U                    /* in mstatus */
#define FLOATING_POINT 0x2000U           /* in mstatus: registers and unit, as after reset */

static uint32_t tick_period;

/* slli x0, ebreak, srai x0 must be adjacent, uncompressed, in one page. */
__attribute__((noinline, aligned(16))) intptr_t semihosting_call(int operation,
                                                                 const void *parameters)
{
    register intptr_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = parameters;
    __asm__ volatile(".option push\n\t.option norvc\n\t.balign 16\n\tslli x0, x0, "
                     "0x1f\n\tebreak\n\tsrai x0, x0, 7\n\t"
                     ".option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
    return a0;
}

void board_start(void)
{
#if defined(__riscv_flen)
    __asm__ volatile(
        ".option push\n\t.option arch, +zicsr\n\tcsrs mstatus, %0\n\t.option pop" ::"r"(
            FLOATING_POINT));
#endif
}

uint32_t board_mark(void)
{
    uintptr_t retired;
    __asm__ volatile(".option push\n\t.option arch, +zicsr\n\tcsrr %0, minstret\n\t.option pop"
                     : "=r"(retired)::"memory");
    return (uint32_t)retired;
}

static void compare_at(uint64_t time)
{
    REGISTER(MACHINE_TIME_COMPARE + 4U) = UINT32_MAX;
    REGISTER(MACHINE_TIME_COMPARE) = (uint32_t)time;
    REGISTER(MACHINE_TIME_COMPARE + 4U) = (uint32_t)(time >> 32U);
}

/* The only interrupt is the timer's. Any other trap ends the image. */
__attribute__((interrupt, aligned(4))) void board_trap(void)
{
    static uint64_t due;
    intptr_t cause;
    __asm__ volatile(".option push\n\t.option arch, +zicsr\n\tcsrr %0, mcause\n\t.option pop"
                     : "=r"(cause));
    if (cause >= 0) {
        board_text("fault\n");
        board_exit(99);
    }
    due = ((due == 0U) ? board_clock() : due) + tick_period;
    while ((uint32_t)due - board_clock() > tick_period) {
        due += tick_period;
    }
    compare_at(due);
    board_tick();
}

__attribute__((weak)) void board_tick(void) {}

void board_tick_every(uint32_t microseconds)
{
    tick_period = microseconds * BOARD_CLOCK_PER_US;
    compare_at((uint64_t)board_clock() + tick_period);
    __asm__ volatile(".option push\n\t.option arch, +zicsr\n\tcsrw mtvec, %0\n\tcsrs mie, "
                     "%1\n\tcsrs mstatus, %2\n\t"
                     ".option pop" ::"r"(&board_trap),
                     "r"(TIMER_INTERRUPT), "r"(INTERRUPTS)
                     : "memory");
}

uint32_t board_instructions_since(uint32_t mark)
{
    return board_mark() - mark;
}

void board_begin(void)
{
    memset(&image_bss_start, 0, (size_t)((uintptr_t)&image_bss_end - (uintptr_t)&image_bss_start));
    board_start();
    board_exit(main());
}

/* The first instructions. There is no stack yet. */
__attribute__((naked, section(".vectors"))) void board_reset(void)
{
    __asm__(".option push\n\t.option norelax\n\tla gp, __global_pointer$\n\t.option pop\n\tla sp, "
            "image_stack_top\n\t"
            "call board_begin");
}
