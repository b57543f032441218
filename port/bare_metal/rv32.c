/* davar on a bare board - RISC-V: the counter of retired instructions, semihosting by its magic sequence. */
#include "board.h"
#include "semihosting.h"

#include <string.h>

extern uint32_t image_bss_start;
extern uint32_t image_bss_end;

int main(void);
void board_begin(void);

/* slli x0, ebreak, srai x0 must stand together, uncompressed, in one page. */
__attribute__((noinline, aligned(16))) intptr_t semihosting_call(int operation, const void *parameters)
{
    register intptr_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = parameters;
    __asm__ volatile(".option push\n\t.option norvc\n\t.balign 16\n\tslli x0, x0, 0x1f\n\tebreak\n\tsrai x0, x0, 7\n\t"
                     ".option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
    return a0;
}

void board_start(void) {}

uint32_t board_mark(void)
{
    uint32_t retired;
    __asm__ volatile(".option push\n\t.option arch, +zicsr\n\tcsrr %0, minstret\n\t.option pop"
                     : "=r"(retired)::"memory");
    return retired;
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
