/* davar tests - the cost of davar/select.h on this target, in instructions (exact under -icount) and
 * bytes. One line "name value" per figure; tools/support/targets.py reads them. */
#include "measuring.h"

#include "davar/select.h"

#include <math.h>
#include <string.h>

#define BLOCKS 400U

static davar_select_gyro_t gyro[DAVAR_SELECT_GYROS];
static davar_select_pair_t pair[DAVAR_SELECT_PAIRS(DAVAR_SELECT_GYROS)];
static davar_select_t selection;
static davar_select_verdict_t verdict;
static uint32_t checksum;

static void add_bits(void)
{
    for (uint32_t i = 0U; i < DAVAR_SELECT_GYROS; i++) {
        uint32_t bits;
        memcpy(&bits, &verdict.weight[i], sizeof bits);
        checksum = (checksum * 31U) + bits + verdict.fault[i];
    }
    checksum = (checksum * 31U) + verdict.chosen;
}

/* One rate of the last gyro: it becomes louder halfway, then its mean moves, it repeats one value, and
 * its samples are missing. */
static float spoilt(float noise, uint32_t t)
{
    float rate = noise;
    if (t >= (BLOCKS - 30U)) {
        rate = NAN;
    } else if (t >= (BLOCKS - 60U)) {
        rate = 1.0F;
    } else if (t >= (BLOCKS / 2U)) {
        rate = (3.0F * noise) + ((t >= (BLOCKS - 110U)) ? 1.0F : 0.0F);
    } else {
        /* healthy */
    }
    return rate;
}

static void measure(const davar_select_config_t *config, const char *add, const char *update,
                    const char *worst, const char *bytes)
{
    float rates[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES];
    const uint32_t values = (uint32_t)config->gyros * config->axes;
    const uint32_t nothing = instructions_of_nothing();
    uint32_t added = 0U;
    uint32_t total = 0U;
    uint32_t most = 0U;
    if (davar_select_init(&selection, config, gyro, pair) != DAVAR_SELECT_OK) {
        board_exit(1);
    }
    for (uint32_t t = 0U; t < BLOCKS; t++) {
        for (uint32_t k = 0U; k < config->block; k++) {
            for (uint32_t i = 0U; i < values; i++) {
                const float noise = (float)noise_of(4U) * (1.0F / 4096.0F);
                rates[i] = ((i + config->axes) < values) ? noise : spoilt(noise, t);
            }
            const uint32_t mark = board_mark();
            (void)davar_select_add(&selection, rates);
            added += board_instructions_since(mark) - nothing;
        }
        const uint32_t mark = board_mark();
        davar_select_update(&selection, &verdict);
        const uint32_t spent = board_instructions_since(mark) - nothing;
        total += spent;
        most = larger(most, spent);
        add_bits();
    }
    board_figure(add, added / (BLOCKS * config->block));
    board_figure(update, total / BLOCKS);
    board_figure(worst, most);
    board_figure(bytes, (uint32_t)(sizeof selection + (config->gyros * sizeof gyro[0]) +
                                   (DAVAR_SELECT_PAIRS(config->gyros) * sizeof pair[0])));
}

int main(void)
{
    static const davar_select_config_t two = {
        .gyros = 2U, .axes = 1U, .block = 10U, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
    static const davar_select_config_t three = {
        .gyros = 3U, .axes = 3U, .block = 10U, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
    static const davar_select_config_t four = {
        .gyros = 4U, .axes = 3U, .block = 10U, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
    measure(&two, "select2_add", "select2_update", "select2_worst", "select2_bytes");
    measure(&three, "select3_add", "select3_update", "select3_worst", "select3_bytes");
    measure(&four, "select4_add", "select4_update", "select4_worst", "select4_bytes");
    board_figure("select_checksum", checksum);
    return 0;
}
