/* davar - octaves on ARMv7-M and ARMv8-M Mainline, in their own instructions: what slide_octaves in slide.h says in C, for
 * int16 samples, and the same bits, in fewer instructions. A tau_t comes and goes in one instruction, and nothing is
 * spilled. -DDAVAR_PORTABLE leaves it out.
 *
 *   r0   tau                          r8        span of the first of two, in samples
 *   r1   leading edge                 r9, r10   newest, oldest sample
 *   r2   trailing edge                r11, r12  taps half a span before and behind the edges
 *   r3   octaves to go */
#ifndef DAVAR_SRC_SLIDE_ARMV7M_H
#define DAVAR_SRC_SLIDE_ARMV7M_H

#include <stddef.h>

_Static_assert((offsetof(tau_t, sum) == 0U) && (offsetof(tau_t, head) == 8U) && (offsetof(tau_t, tail) == 12U) &&
                   (sizeof(tau_t) == 16U),
               "SLIDE_OCTAVE");
_Static_assert((offsetof(allan_t, m) == 0U) && (offsetof(allan_t, tau) == 4U) && (offsetof(allan_t, count) == 20U),
               "SLIDE_READ");

#define SLIDE_READ                                                                                                     \
    "ldrb r3, [r0, #20]\n"                                                                                             \
    "ldrd r8, r0, [r0]\n"                                                                                              \
    "ldr r8, [r8]\n"                                                                                                   \
    "ldrsh r9, [r1]\n"                                                                                                 \
    "ldrsh r10, [r2]\n"                                                                                                \
    "sub r11, r1, r8, lsl #1\n"                                                                                        \
    "ldrsh r11, [r11]\n"                                                                                               \
    "ldrsh r12, [r2, r8, lsl #1]\n"

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

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter" /* they are in r0, r1 and r2 */
__attribute__((naked, noinline)) static void slide_octaves(allan_t *allan, const sample_t *head, const sample_t *tail)
{
    __asm__ volatile(
        "push {r4, r5, r6, r7, r8, r9, r10, r11, lr}\n" SLIDE_READ "tst r3, #1\n"
        "bne 2f\n"
        "lsl r8, r8, #1\n"
        "1:\n" SLIDE_OCTAVE("1") "2:\n" SLIDE_OCTAVE("2") /* two at a time; the second first when they are odd */
        "lsl r8, r8, #2\n"
        "subs r3, r3, #2\n"
        "bhi 1b\n"
        "pop {r4, r5, r6, r7, r8, r9, r10, r11, pc}\n");
}
#pragma GCC diagnostic pop

#endif
