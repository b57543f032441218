/* Keeps the state of an instance over a brown-out: what it learned in minutes is available again
 * after power-up.
 *
 *   start:      init, restore the newest intact image, report how many samples were missed
 *   each minute, and when the supply falls: save. The brown-out interrupt only sets a flag, and
 *               the main loop saves within a few ms
 *
 * Saves alternate between two slots, so one of them is always intact, whenever the power fails.
 *
 * For your board: fill storage_read and storage_write (FRAM, EEPROM, backup RAM, or flash with an
 * erase layer). Compute brown_out_missed from a clock that keeps running (RTC). Without such a
 * clock every pause counts as one sample, because the window only needs a gap. No push or take may
 * be in progress during a save. Call it from the main loop, which also takes, with the sample
 * interrupt masked. Never call it from an interrupt that can preempt a push or a take. */
#include "brown_out.h"

#include "davar/state.h"

static const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
#define TAUS (sizeof taus / sizeof taus[0])
#define WINDOW 600U

static uint64_t memory[DAVAR_MEMORY(Q15, longest(WINDOW), shortest(WINDOW), stride(1), largest(64),
                                    taus(TAUS)) /
                       8];
static davar_config_t config;
static davar_t gyro;

static bool read_slot(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    return storage_read(offset, data, bytes);
}

static bool write_slot(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    return storage_write(offset, data, bytes);
}

static const davar_storage_t storage = {read_slot, write_slot, NULL, BROWN_OUT_SLOT};

davar_status_t brown_out_start(bool *is_restored)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.05;
    config.window.grow = 1;
    config.window.longest = WINDOW;
    config.taus = taus;
    config.tau_count = TAUS;
    davar_status_t status = davar_init_q15(&gyro, &config, memory, sizeof memory);
    *is_restored = (status == DAVAR_OK) && (davar_state_restore(&gyro, &storage) == DAVAR_STATE_OK);
    if (*is_restored) {
        davar_gap(&gyro, brown_out_missed());
    }
    return status; /* nothing was restored: it starts from scratch, which is not a fault */
}

bool brown_out_save(void)
{
    return davar_state_save(&gyro, &storage) ==
           DAVAR_STATE_OK; /* on failure the older image remains */
}

davar_t *brown_out_gyro(void)
{
    return &gyro;
}
