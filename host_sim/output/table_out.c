/* davar-sim - a table for people. */
#include "output/table_out.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define LINE_BYTES 256U
#define CELL_BYTES 40U

void table_out_header(rows_out_t *rows, bool floored)
{
    rows_out_put(rows, "    time  channel                  ARW  95 %               ");
    rows_out_put(rows, floored ? "     floor  95 %               " : "");
    rows_out_put(rows, "   window\n       s                deg/sqrt(h)  deg/sqrt(h)        ");
    rows_out_put(rows, floored ? "deg/sqrt(h)  deg/sqrt(h)       " : "");
    rows_out_put(rows, "  samples\n");
}

/* A value with its interval, or its upper limit alone. */
static void put_estimate(rows_out_t *rows, double value, double low, double high)
{
    char first[CELL_BYTES] = "-";
    char second[CELL_BYTES] = "";
    char text[LINE_BYTES];
    if (isfinite(value)) {
        (void)snprintf(first, sizeof first, "%.4g", value);
        (void)snprintf(second, sizeof second, isfinite(high) ? "%.4g to %.4g" : "at least %.4g",
                       low, high);
    } else if (isfinite(high)) {
        (void)snprintf(first, sizeof first, "< %.4g", high);
    } else { /* nothing is known */
    }
    (void)snprintf(text, sizeof text, "%11s  %-17s  ", first, second);
    rows_out_put(rows, text);
}

static const char *reason_of(davar_noise_t noise)
{
    static const char *const REASON[] = {
        [DAVAR_NOISE_UNKNOWN] = "  too few samples",
        [DAVAR_NOISE_WHITE] = "",
        [DAVAR_NOISE_MIXED] = "  not white noise alone",
        [DAVAR_NOISE_CONSTANT] = "  constant, or below a count",
        [DAVAR_NOISE_COARSE] = "  hidden by counts",
        [DAVAR_NOISE_FILTERED] = "  hidden by a filter",
    };
    return ((size_t)noise < (sizeof REASON / sizeof REASON[0])) ? REASON[noise] : "";
}

void table_out_row(rows_out_t *rows, const char *channel, const epoch_row_t *row)
{
    const davar_result_t *result = row->result;
    const davar_coefficient_t *walk = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    char text[LINE_BYTES];
    (void)snprintf(text, sizeof text, "%8.2f  %-14s", row->time_s, channel);
    rows_out_put(rows, text);
    put_estimate(rows, walk->present ? walk->value : (double)NAN, walk->low, walk->high);
    if (row->floor != NULL) {
        put_estimate(rows, (double)row->floor->value, (double)row->floor->low,
                     (double)row->floor->high);
    }
    (void)snprintf(text, sizeof text, "%7" PRIu32, result->window_samples);
    rows_out_put(rows, text);
    if (row->misfit != NULL) {
        (void)snprintf(text, sizeof text, "  model health %.2f", row->misfit->health);
        rows_out_put(rows, text);
    }
    rows_out_put(rows, walk->present ? "" : reason_of(result->noise));
    rows_out_put(rows, result->unstable ? "  noise may be changing" : "");
    rows_out_put(rows, ((row->report != NULL) && row->report->alarm) ? "  ALARM" : "");
    rows_out_put(rows, "\n");
}
