/* davar tests - states that were seen, with the path to each, and the layers of a breadth-first
 * search. */
#ifndef DAVAR_TESTS_STATES_H
#define DAVAR_TESTS_STATES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define NO_STATE UINT32_MAX

/* Two hashes of 64 bits. With 10^7 states, the chance of any collision is below 10^-24. */
typedef struct {
    uint64_t word[2]; /* both 0: a free place */
} state_key_t;

/* The states by number, from 0. */
static struct {
    state_key_t *place;
    size_t size;
    uint32_t count;
    uint32_t *from;  /* the state before */
    uint8_t *action; /* that leads here */
} states;

/* Images of states, all of `size` bytes. */
typedef struct {
    unsigned char *image;
    size_t count;
    size_t room;
    size_t size;
} layer_t;

static void *allocated(void *pointer)
{
    if (pointer == NULL) {
        abort();
    }
    return pointer;
}

static void key_add(state_key_t *key, const void *data, size_t size)
{
    for (size_t i = 0U; i < size; i += 8U) {
        uint64_t next = 0U;
        memcpy(&next, (const unsigned char *)data + i, ((size - i) < 8U) ? (size - i) : 8U);
        key->word[0] = (key->word[0] ^ next) * UINT64_C(0x9E3779B97F4A7C15);
        key->word[0] ^= key->word[0] >> 29U;
        key->word[1] = (key->word[1] + next + i) * UINT64_C(0xD6E8FEB86659FD93);
        key->word[1] ^= key->word[1] >> 32U;
    }
}

static bool key_equal(const state_key_t *a, const state_key_t *b)
{
    return (a->word[0] == b->word[0]) && (a->word[1] == b->word[1]);
}

/* The place of this key, or the free one where it belongs. */
static state_key_t *states_find(state_key_t *place, size_t size, const state_key_t *key)
{
    static const state_key_t none = {{0U, 0U}};
    size_t at = (size_t)key->word[0] & (size - 1U);
    while (!key_equal(&place[at], &none) && !key_equal(&place[at], key)) {
        at = (at + 1U) & (size - 1U);
    }
    return &place[at];
}

static void states_grow(void)
{
    const size_t size = (states.size == 0U) ? 65536U : (2U * states.size);
    state_key_t *const larger = allocated(calloc(size, sizeof *larger));
    for (size_t i = 0U; i < states.size; i++) {
        *states_find(larger, size, &states.place[i]) = states.place[i];
    }
    free(states.place);
    states.place = larger;
    states.size = size;
    states.from = allocated(realloc(states.from, size * sizeof *states.from));
    states.action = allocated(realloc(states.action, size * sizeof *states.action));
}

static void states_clear(void)
{
    states.count = 0U;
    if (states.size > 0U) {
        memset(states.place, 0, states.size * sizeof *states.place);
    }
}

/* True: a new state; its number is states.count - 1. */
static bool states_add(state_key_t key, uint32_t from, uint8_t action)
{
    if ((2U * ((size_t)states.count + 1U)) > states.size) {
        states_grow();
    }
    state_key_t *const place = states_find(states.place, states.size, &key);
    if (key_equal(place, &key)) {
        return false;
    }
    *place = key;
    states.from[states.count] = from;
    states.action[states.count] = action;
    states.count++;
    return true;
}

/* The place of one more image. */
static unsigned char *layer_add(layer_t *layer)
{
    if (layer->count == layer->room) {
        layer->room = (layer->room == 0U) ? 256U : (2U * layer->room);
        layer->image = allocated(realloc(layer->image, layer->room * layer->size));
    }
    layer->count++;
    return layer->image + ((layer->count - 1U) * layer->size);
}

#endif
