/* Prints the status of davar_init_q31 for given settings, as davar_status_text. The arguments are
 * the values of the options in test_settings.py, in its order. */
#include "davar/davar.h"
#include "davar_law_id.h"

#include <stdio.h>
#include <stdlib.h>

static uint32_t whole(const char *text)
{
    return (uint32_t)strtoul(text, NULL, 10);
}

static void range(const char *text, double *low, double *high)
{
    char *end = NULL;
    *low = strtod(text, &end);
    *high = strtod(end + 1, NULL);
}

int main(int count, char *word[])
{
    static uint32_t taus[DAVAR_TAUS_MAX];
    davar_config_t config = davar_default_config;
    uint64_t no_memory[1] = {0};
    davar_t davar;
    if (count != 18) {
        return 2;
    }
    config.law = davar_law_of_id((davar_law_id_t)whole(word[1]), true);
    config.window.longest = whole(word[2]);
    config.window.shortest = whole(word[3]);
    config.moments.segment = whole(word[4]);
    config.window.grow = whole(word[5]);
    config.window.shrink = whole(word[6]);
    config.stride = whole(word[7]);
    config.glr.block = whole(word[8]);
    config.glr.shock_blocks = whole(word[9]);
    range(word[10], &config.moments.kurtosis_low, &config.moments.kurtosis_high);
    range(word[11], &config.moments.contribution_low, &config.moments.contribution_high);
    for (char *text = word[12]; config.tau_count < DAVAR_TAUS_MAX; text++) {
        taus[config.tau_count] = (uint32_t)strtoul(text, &text, 10);
        config.tau_count++;
        if (*text == '\0') {
            break;
        }
    }
    config.taus = taus;
    config.engine = davar_grid_of(whole(word[13]) != 0U, true);
    config.glr.false_alarms_per_hour = strtod(word[14], NULL);
    config.glr.cut_interval_s = strtod(word[15], NULL);
    config.rate_hz = strtod(word[16], NULL);
    config.unit_per_count = strtod(word[17], NULL);
    const davar_status_t status = davar_init_q31(&davar, &config, no_memory, 0U);
    (void)puts((status == DAVAR_ERR_MEMORY_SIZE) ? "ok" : davar_status_text(status));
    return 0;
}
