/* The state of an instance over a brown-out: what it has learned in minutes is there again when the power is.
 *
 *   start:      init, restore the newest whole image, say how many samples were missed
 *   each minute, and when the supply falls: save. The brown-out interrupt only sets a flag; a few ms are enough for the main loop
 *
 * Two slots are written in turn, the newest last, so that at any moment one of them is whole, wherever the power is cut.
 *
 * For your board: fill storage_read and storage_write (FRAM, EEPROM, backup RAM, or flash behind an erase layer), and brown_out_missed from a
 * clock that runs on (RTC). Without one every pause counts as one sample: the window only needs to know that there was a gap.
 * A save needs push and take quiet: call it from the main loop, which takes, with the sample's interrupt masked. Never from an interrupt
 * that a push or a take may be under. */
#include "brown_out.h"

#include "davar/state.h"

static const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
#define TAUS (sizeof taus / sizeof taus[0])
#define WINDOW 600U

static uint64_t memory[DAVAR_MEMORY_Q15(WINDOW, 64, TAUS, 4) / 8];
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
    *is_restored = (status == DAVAR_OK) && (davar_state_restore(&gyro, &storage) == DAVAR_OK);
    if (*is_restored) {
        davar_gap(&gyro, brown_out_missed());
    }
    return status; /* nothing restored: it begins anew, and that is no fault */
}

bool brown_out_save(void)
{
    return davar_state_save(&gyro, &storage) == DAVAR_OK; /* not: the older image is still there */
}

davar_t *brown_out_gyro(void)
{
    return &gyro;
}
