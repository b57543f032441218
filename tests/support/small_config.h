/* davar tests - a configuration whose windows (20 to 40 samples) are short enough to be counted by
 * hand. */
#ifndef DAVAR_TESTS_SMALL_CONFIG_H
#define DAVAR_TESTS_SMALL_CONFIG_H

#include "davar/davar.h"

static inline davar_config_t small_config(const uint32_t *taus, uint8_t count)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 300.0;
    config.window.longest = 40U;
    config.window.shortest = 20U;
    config.moments.segment = 5U;
    config.taus = taus;
    config.tau_count = count;
    return config;
}

#endif
