/* davar-sim - progress. */
#include "recording/progress.h"

#include "common/sim_clock.h"

#include <inttypes.h>
#include <stdio.h>
#include <unistd.h>

#define INTERVAL_S 1.0

void progress_start(progress_t *progress, show_t show)
{
    const bool terminal = (isatty(STDERR_FILENO) == 1);
    progress->terminal = terminal;
    const bool free_line = terminal && (isatty(STDOUT_FILENO) != 1);
    progress->shown = (show == SHOW_ALWAYS) || ((show == SHOW_AUTO) && free_line);
    progress->dirty = false;
    progress->next_s = sim_clock_s() + INTERVAL_S;
}

void progress_show(progress_t *progress, const char *doing, double fraction, uint64_t rows)
{
    if (!progress->shown) {
        return;
    }
    const double now_s = sim_clock_s();
    if (now_s < progress->next_s) {
        return;
    }
    progress->next_s = now_s + INTERVAL_S;
    progress->dirty = progress->terminal;
    const char *before = progress->terminal ? "\r" : "";
    const char *after = progress->terminal ? "" : "\n";
    if (fraction < 0.0) {
        (void)fprintf(stderr, "%sdavar-sim: %s %" PRIu64 " rows%s", before, doing, rows, after);
    } else {
        (void)fprintf(stderr, "%sdavar-sim: %s %3.0f %%%s", before, doing, 100.0 * fraction, after);
    }
    (void)fflush(stderr);
}

void progress_clear(progress_t *progress)
{
    if (progress->dirty) {
        (void)fputs("\r\033[K", stderr);
        progress->dirty = false;
    }
}
