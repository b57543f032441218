/* davar tests - how deep a stack gets on a target: the words below the stack pointer are painted,
 * and the painted ones that are left are counted. STACK_WORDS: how far, which the includer defines. */
#ifndef DAVAR_TESTS_STACK_PAINT_H
#define DAVAR_TESTS_STACK_PAINT_H

#include <stdint.h>

#define PAINT 0xA5C3965AU
#define MARGIN 32U /* words that the painting itself needs */

static inline uintptr_t stack_pointer(void)
{
    uintptr_t pointer;
#if defined(__riscv)
    __asm__ volatile("mv %0, sp" : "=r"(pointer));
#else
    __asm__ volatile("mov %0, sp" : "=r"(pointer));
#endif
    return pointer;
}

static __attribute__((noinline)) void paint(uintptr_t from)
{
    volatile uint32_t *const below = (volatile uint32_t *)from - MARGIN - STACK_WORDS;
    for (uint32_t i = 0U; i < STACK_WORDS; i++) {
        below[i] = PAINT;
    }
}

/* Bytes between the caller's stack pointer and the deepest word that was overwritten. */
static __attribute__((noinline)) uint32_t used(uintptr_t from)
{
    const volatile uint32_t *const below = (const volatile uint32_t *)from - MARGIN - STACK_WORDS;
    uint32_t clean = 0U;
    while ((clean < STACK_WORDS) && (below[clean] == PAINT)) {
        clean++;
    }
    return (MARGIN + STACK_WORDS - clean) * (uint32_t)sizeof(uint32_t);
}

#endif
