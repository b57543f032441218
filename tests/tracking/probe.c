/* davar tests - the detector of changes as a filter, for tests/tracking/test_reference.py. Input:
 * one line `K SHOCK PER_HOUR`, then one block per line: its samples' sum and sum of squares, or
 * `gap`. Output per block: resolved, dropped, cut, alarm, the present place, those of the cut and
 * of the alarm, f, the gain, then the trailing and the centred window. */
#include "detector/glr.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static davar_glr_t state;
static davar_glr_config_t config;

static void print(const davar_glr_event_t *event)
{
    davar_glr_window_t trailing;
    davar_glr_window_t centred;
    davar_glr_trailing(&state, &config, &trailing);
    const bool is_there = davar_glr_centred(&state, &config, config.half, &centred);
    printf("%" PRIu32 " %" PRIu32 " %d %d %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRId32,
           event->resolved, event->dropped, event->is_cut ? 1 : 0, event->is_alarm ? 1 : 0,
           state.now.at, state.cut.at, state.alarm.at, davar_glr_dispersion(&state), event->gain);
    printf(" %" PRIu32 " %" PRIu32 " %d %" PRIu32 " %" PRIu32 "\n", trailing.begin, trailing.end,
           is_there ? 1 : 0, centred.begin, centred.end);
}

int main(void)
{
    davar_glr_wish_t wish = {100.0, 0.01, 300.0, 6000U, 10U, 2U, true};
    char words[3][32];
    if (scanf("%31s %31s %31s", words[0], words[1], words[2]) != 3) {
        return 1;
    }
    wish.block = (uint32_t)strtoul(words[0], NULL, 10);
    wish.shock = (uint32_t)strtoul(words[1], NULL, 10);
    wish.false_alarms_per_hour = strtod(words[2], NULL);
    davar_glr_start(&config, &wish);
    davar_glr_reset(&state);
    printf("%.17g %.17g\n", config.alarm / 65536.0, config.cut / 65536.0);
    char word[32];
    while (scanf("%31s", word) == 1) {
        davar_glr_event_t event;
        if (strcmp(word, "gap") == 0) {
            davar_glr_skip(&state, &config, &event);
        } else if (scanf("%31s", words[0]) == 1) {
            davar_glr_push_q15(&state, &config, (int32_t)strtol(word, NULL, 10),
                               strtoull(words[0], NULL, 10), &event);
        } else {
            return 1;
        }
        print(&event);
    }
    return 0;
}
