/* davar - octaves on ARMv7-M and ARMv8-M Mainline, in their own instructions: what slide_octaves in slide.h says in C, for
 * int16 samples, and the same bits. Two thirds of the instructions: all four words of a tau_t in one load and one store,
 * and nothing spilled. -DDAVAR_PORTABLE leaves it out. */
#ifndef DAVAR_SRC_SLIDE_ARMV7M_H
#define DAVAR_SRC_SLIDE_ARMV7M_H

#include <stddef.h>

_Static_assert((offsetof(tau_t, sum) == 0U) && (offsetof(tau_t, head) == 8U) && (offsetof(tau_t, tail) == 12U) &&
                   (sizeof(tau_t) == 16U),
               "r4 to r7 of an octave");
_Static_assert((offsetof(stages_t, ring.sample) == 0U) && (offsetof(stages_t, ring.capacity) == 4U) &&
                   (offsetof(stages_t, allan.m) == 12U) && (offsetof(stages_t, allan.tau) == 16U) &&
                   (offsetof(stages_t, allan.count) == 32U),
               "what is read first");

/* One octave. r0 tau, r1 and r2 the edges, r3 longest span on this side of a turn, r8 half the first span of two octaves,
 * r9 newest, r10 oldest sample, r11 and r12 the taps half a span before and behind; r4:r5 sum, r6 head, r7 tail. */
#define SLIDE_OCTAVE(shift)                                                                                            \
    "ldmia r0, {r4, r5, r6, r7}\n"                                                                                     \
    "add r6, r6, r9\n"                                                                                                 \
    "sub r6, r6, r11, lsl #1\n"                                                                                        \
    "sub r11, r1, r8, lsl #" shift "\n"                                                                                \
    "ldrsh r11, [r11]\n"                                                                                               \
    "add r6, r6, r11\n"                                                                                                \
    "smlal r4, r5, r6, r6\n" /* + head^2 - tail^2 */                                                                   \
    "rsb lr, r7, #0\n"                                                                                                 \
    "smlal r4, r5, r7, lr\n"                                                                                           \
    "add r7, r7, r10\n"                                                                                                \
    "sub r7, r7, r12, lsl #1\n"                                                                                        \
    "ldrsh r12, [r2, r8, lsl #" shift "]\n"                                                                            \
    "add r7, r7, r12\n"                                                                                                \
    "stmia r0!, {r4, r5, r6, r7}\n"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter" /* r0, r1, r2 */
__attribute__((naked, noinline)) static void slide_octaves(stages_t *stages, uint32_t head, uint32_t tail)
{
    __asm__ volatile("push {r4, r5, r6, r7, r8, r9, r10, r11, lr}\n"
                     "ldrd r4, r5, [r0]\n" /* samples, capacity */
                     "ldr r3, [r0, #12]\n"
                     "ldrb r6, [r0, #32]\n"
                     "ldr r0, [r0, #16]\n"
                     "ldr r8, [r3]\n" /* m */
                     "lsl r6, r8, r6\n" /* the longest span */
                     "ldrsh r9, [r4, r1, lsl #1]\n"
                     "ldrsh r10, [r4, r2, lsl #1]\n"
                     "subs r3, r1, r8\n" /* m before, m behind */
                     "it lo\n"
                     "addlo r3, r3, r5\n"
                     "ldrsh r11, [r4, r3, lsl #1]\n"
                     "add r3, r2, r8\n"
                     "cmp r3, r5\n"
                     "it hs\n"
                     "subhs r3, r3, r5\n"
                     "ldrsh r12, [r4, r3, lsl #1]\n"
                     "mvn r7, r2\n"
                     "add r7, r7, r5\n" /* reach behind; r1 is the reach before */
                     "lsl r5, r5, #1\n"
                     "push {r1, r5, r6, r7}\n"
                     "cmp r1, r7\n" /* the least of both and the longest span */
                     "ite lo\n"
                     "movlo r3, r1\n"
                     "movhs r3, r7\n"
                     "cmp r3, r6\n"
                     "it hi\n"
                     "movhi r3, r6\n"
                     "cmp r3, r8, lsl #1\n"
                     "add r1, r4, r1, lsl #1\n"
                     "add r2, r4, r2, lsl #1\n"
                     "bhs 2f\n"
                     "1:\n" /* an edge turns, or both */
                     "ldmia sp, {r4, r5, r6, r7}\n"
                     "mvn lr, #0\n"
                     "cmp r4, r8, lsl #1\n"
                     "ittt lo\n"
                     "addlo r1, r1, r5\n"
                     "movlo r4, lr\n"
                     "strlo r4, [sp]\n"
                     "cmp r7, r8, lsl #1\n"
                     "ittt lo\n"
                     "sublo r2, r2, r5\n"
                     "movlo r7, lr\n"
                     "strlo r7, [sp, #12]\n"
                     "cmp r4, r7\n"
                     "ite lo\n"
                     "movlo r3, r4\n"
                     "movhs r3, r7\n"
                     "cmp r3, r6\n"
                     "it hi\n"
                     "movhi r3, r6\n"
                     "2:\n" SLIDE_OCTAVE("2") /* two at a time */
                     "cmp r3, r8, lsl #2\n"
                     "blo 3f\n" SLIDE_OCTAVE("3")
                     "lsl r8, r8, #2\n"
                     "cmp r3, r8, lsl #1\n"
                     "bhs 2b\n"
                     "b 4f\n"
                     "3:\n"
                     "lsl r8, r8, #1\n"
                     "4:\n"
                     "ldr r6, [sp, #8]\n"
                     "cmp r6, r8, lsl #1\n"
                     "bhs 1b\n"
                     "add sp, sp, #16\n"
                     "pop {r4, r5, r6, r7, r8, r9, r10, r11, pc}\n");
}
#pragma GCC diagnostic pop

#endif
