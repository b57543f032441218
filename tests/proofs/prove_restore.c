/* Statement: davar_state_restore, for any storage, reads and writes inside the instance, its memory
 * and its own buffers, and nothing overflows. Every reading gives any bytes, different each time,
 * or fails. The proof does not rely on a checksum, so it covers forged images too. Bound: one
 * configuration of each number type (q15, q31; a value at every sample; window 8, cluster sizes 1
 * and 2). */
#include "davar/davar.h"
#include "davar/state.h"

#include "proof.h"

static bool read_anything(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    (void)offset;
    any_bytes(data, bytes);
    return any_u32(0U, 1U) != 0U;
}

static bool write_nothing(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    (void)data;
    (void)offset;
    (void)bytes;
    return false;
}

#if WIDE
#define INIT davar_init_q31
#define WORDS 2U
#else
#define INIT davar_init_q15
#define WORDS 1U
#endif

static davar_t davar;
static uint64_t memory[DAVAR_MEMORY_SLIDING(WORDS, 8U, 0U, 1U, 2U, 2U, 4U) / 8U];
static const uint32_t taus[2] = {1U, 2U};

void prove(void)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.law = NULL;
    config.window.longest = 8U;
    config.window.shortest = 8U;
    config.moments.segment = 0U;
    config.taus = taus;
    config.tau_count = 2U;
    if (INIT(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        return; /* never, as tests/api shows; Eva cannot represent a double by its bits */
    }
    const size_t slot_bytes = davar_state_bytes(&davar);
    const davar_storage_t storage = {read_anything, write_nothing, NULL, slot_bytes};
    (void)davar_state_restore(&davar, &storage);
    PROVED();
}
