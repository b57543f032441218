/* What a proof says: any value of a range, a statement that must hold, and that the end can be reached. The analyser,
 * Eva of Frama-C, takes each `any` as all values at once. */
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

/* Nothing that does not hold this for all values passes: the call can be reached, and its contract says it must not be. */
#define PROVE(statement) ((statement) ? (void)0 : not_proved())

/* A proof that stops half way has proved nothing: test_proofs.py wants to see that the end is reached. */
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
    unsigned char *const byte =
        data; /* one by one: Frama_C_make_unknown would keep what was there as possible */
    for (size_t i = 0U; i < bytes; i++) {
        byte[i] = Frama_C_unsigned_char_interval(0U, UCHAR_MAX);
    }
}

#endif
