/* The parts of a proof: any value of a range, a statement that must be true, and a check that the
 * end can be reached. The analyser, Eva of Frama-C, treats each `any` as all values together. */
#ifndef PROOF_H
#define PROOF_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "__fc_builtin.h"

/*@ requires \false;
  @ assigns \nothing; */
void not_proved(void);

/* Eva accepts a program only if this is true for all values: otherwise the call can be reached, and
 * its contract forbids that. */
#define PROVE(statement) ((statement) ? (void)0 : not_proved())

/* A proof that stops half way has proved nothing: test_proofs.py checks that the end is reached. */
#define PROVED() Frama_C_show_each_proved()

static inline int32_t any_i32(int32_t low, int32_t high)
{
    return Frama_C_interval(low, high);
}

static inline uint32_t any_u32(uint32_t low, uint32_t high)
{
    return Frama_C_unsigned_int_interval(low, high);
}

static inline uint64_t any_u64(void)
{
    return Frama_C_unsigned_long_long_interval(0U, UINT64_MAX);
}

static inline void any_bytes(void *data, size_t bytes)
{
    /* one by one: Frama_C_make_unknown would keep the old content as a possibility */
    unsigned char *const byte = data;
    for (size_t i = 0U; i < bytes; i++) {
        byte[i] = Frama_C_unsigned_char_interval(0U, UCHAR_MAX);
    }
}

#endif
