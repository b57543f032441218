/* davar - octaves on ARMv7-M and ARMv8-M Mainline, in their own instructions: what slide_octaves in slide.h says in C, for
 * int16 samples, and the same bits, in 18 % fewer instructions per sample. A tau_t comes and goes in one instruction, and
 * nothing is spilled. -DDAVAR_PORTABLE leaves it out.
 *
 *   r0   tau                          r8        half the span of tau, and of every second one after it
 *   r1   leading edge                 r9, r10   newest, oldest sample
 *   r2   trailing edge                r11, r12  taps half a span before and behind the edges
 *   r3   longest span to the next turn
 *   sp   reach before, bytes of the ring, longest span, reach behind
 *
 * An edge turns when its taps begin to lie beyond the end of the ring; its reach is without bounds from then on. */
#ifndef DAVAR_SRC_SLIDE_ARMV7M_H
#define DAVAR_SRC_SLIDE_ARMV7M_H

#include <stddef.h>

_Static_assert((offsetof(tau_t, sum) == 0U) && (offsetof(tau_t, head) == 8U) && (offsetof(tau_t, tail) == 12U) &&
                   (sizeof(tau_t) == 16U),
               "SLIDE_OCTAVE");
_Static_assert((offsetof(stages_t, ring.sample) == 0U) && (offsetof(stages_t, ring.capacity) == 4U) &&
                   (offsetof(stages_t, allan.m) == 12U) && (offsetof(stages_t, allan.tau) == 16U) &&
                   (offsetof(stages_t, allan.count) == 32U) && (sizeof(stages_t) < 256U),
               "SLIDE_READ");

/* r4 samples, r5 capacity, r6 longest span, r8 m */
#define SLIDE_READ                                                                                                     \
    "ldrd r4, r5, [r0]\n"                                                                                              \
    "ldr r3, [r0, #12]\n"                                                                                              \
    "ldrb r6, [r0, #32]\n"                                                                                             \
    "ldr r0, [r0, #16]\n"                                                                                              \
    "ldr r8, [r3]\n"                                                                                                   \
    "lsl r6, r8, r6\n"                                                                                                 \
    "ldrsh r9, [r4, r1, lsl #1]\n"                                                                                     \
    "ldrsh r10, [r4, r2, lsl #1]\n"

/* The taps m before and m behind. */
#define SLIDE_FIRST_TAPS                                                                                               \
    "subs r3, r1, r8\n"                                                                                                \
    "it lo\n"                                                                                                          \
    "addlo r3, r3, r5\n"                                                                                               \
    "ldrsh r11, [r4, r3, lsl #1]\n"                                                                                    \
    "add r3, r2, r8\n"                                                                                                 \
    "cmp r3, r5\n"                                                                                                     \
    "it hs\n"                                                                                                          \
    "subhs r3, r3, r5\n"                                                                                               \
    "ldrsh r12, [r4, r3, lsl #1]\n"

/* r1 is the reach before, capacity - 1 - r2 the one behind; then both are edges. Higher or same: no turn at the first span. */
#define SLIDE_REACH                                                                                                    \
    "mvn r7, r2\n"                                                                                                     \
    "add r7, r7, r5\n"                                                                                                 \
    "lsl r5, r5, #1\n"                                                                                                 \
    "push {r1, r5, r6, r7}\n"                                                                                          \
    "cmp r1, r7\n"                                                                                                     \
    "ite lo\n"                                                                                                         \
    "movlo r3, r1\n"                                                                                                   \
    "movhs r3, r7\n"                                                                                                   \
    "cmp r3, r6\n"                                                                                                     \
    "it hi\n"                                                                                                          \
    "movhi r3, r6\n"                                                                                                   \
    "add r1, r4, r1, lsl #1\n"                                                                                         \
    "add r2, r4, r2, lsl #1\n"                                                                                         \
    "cmp r3, r8, lsl #1\n"

/* The edges whose reach is below the span turn. */
#define SLIDE_TURN                                                                                                     \
    "ldmia sp, {r4, r5, r6, r7}\n"                                                                                     \
    "mvn lr, #0\n"                                                                                                     \
    "cmp r4, r8, lsl #1\n"                                                                                             \
    "ittt lo\n"                                                                                                        \
    "addlo r1, r1, r5\n"                                                                                               \
    "movlo r4, lr\n"                                                                                                   \
    "strlo r4, [sp]\n"                                                                                                 \
    "cmp r7, r8, lsl #1\n"                                                                                             \
    "ittt lo\n"                                                                                                        \
    "sublo r2, r2, r5\n"                                                                                               \
    "movlo r7, lr\n"                                                                                                   \
    "strlo r7, [sp, #12]\n"                                                                                            \
    "cmp r4, r7\n"                                                                                                     \
    "ite lo\n"                                                                                                         \
    "movlo r3, r4\n"                                                                                                   \
    "movhs r3, r7\n"                                                                                                   \
    "cmp r3, r6\n"                                                                                                     \
    "it hi\n"                                                                                                          \
    "movhi r3, r6\n"

/* r4:r5 sum, r6 head, r7 tail; `shift` makes the bytes of the span of r8. The sum takes head^2 - tail^2. */
#define SLIDE_OCTAVE(shift)                                                                                            \
    "ldmia r0, {r4, r5, r6, r7}\n"                                                                                     \
    "add r6, r6, r9\n"                                                                                                 \
    "sub r6, r6, r11, lsl #1\n"                                                                                        \
    "sub r11, r1, r8, lsl #" shift "\n"                                                                                \
    "ldrsh r11, [r11]\n"                                                                                               \
    "add r6, r6, r11\n"                                                                                                \
    "smlal r4, r5, r6, r6\n"                                                                                           \
    "rsb lr, r7, #0\n"                                                                                                 \
    "smlal r4, r5, r7, lr\n"                                                                                           \
    "add r7, r7, r10\n"                                                                                                \
    "sub r7, r7, r12, lsl #1\n"                                                                                        \
    "ldrsh r12, [r2, r8, lsl #" shift "]\n"                                                                            \
    "add r7, r7, r12\n"                                                                                                \
    "stmia r0!, {r4, r5, r6, r7}\n"

#define SLIDE_FIRST_OCTAVE SLIDE_OCTAVE("2")
#define SLIDE_SECOND_OCTAVE SLIDE_OCTAVE("3")

/* Two octaves at a time, to the next turn; the first of them is in front of it. */
#define SLIDE_TO_TURN                                                                                                  \
    "2:\n" SLIDE_FIRST_OCTAVE "cmp r3, r8, lsl #2\nblo 3f\n" SLIDE_SECOND_OCTAVE                                       \
    "lsl r8, r8, #2\ncmp r3, r8, lsl #1\nbhs 2b\nb 4f\n3:\nlsl r8, r8, #1\n4:\n"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter" /* they are in r0, r1 and r2 */
__attribute__((naked, noinline)) static void slide_octaves(stages_t *stages, uint32_t head_index, uint32_t tail_index)
{
    __asm__ volatile("push {r3, r4, r5, r6, r7, r8, r9, r10, r11, lr}\n" SLIDE_READ SLIDE_FIRST_TAPS SLIDE_REACH
                     "bhs 2f\n"
                     "1:\n" SLIDE_TURN SLIDE_TO_TURN "ldr r6, [sp, #8]\n" /* are there longer spans? */
                     "cmp r6, r8, lsl #1\n"
                     "bhs 1b\n"
                     "add sp, sp, #16\n"
                     "pop {r3, r4, r5, r6, r7, r8, r9, r10, r11, pc}\n");
}
#pragma GCC diagnostic pop

#endif
