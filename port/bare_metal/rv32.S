/* davar on a bare board - start-up of a RISC-V core: stack, gp, .bss, FPU none. */
    .section .vectors, "ax"
    .globl board_reset
board_reset:
    .option push
    .option norelax
    la gp, __global_pointer$
    .option pop
    la sp, image_stack_top
    call board_begin
