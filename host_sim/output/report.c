/* davar-sim - notes, and counts of input faults. */
#include "output/report.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define COARSE_LEVELS 1024.0

/* Chance withholds fewer than one result in so many, even if all windows overlap. */
#define FEW 20U

static void note_units(const selection_t *selection)
{
    for (size_t c = 0; c < selection->count; c++) {
        if (selection->unit[c] == UNIT_OTHER) {
            (void)fprintf(stderr,
                          "davar-sim: note: column %s is not an angular rate: in the results, read "
                          "deg/s as the column's own unit\n",
                          selection->name[c]);
        }
    }
}

static void note_scale(const options_t *options, const quantisation_t *quantisation)
{
    if ((options->arith == ARITH_FIXED) && !(options->setup.lsb > 0.0)) {
        (void)fprintf(stderr, "davar-sim: note: no --lsb: using counts of 2^%d = %.9g\n",
                      (int)lround(log2(quantisation->unit_per_count)),
                      quantisation->unit_per_count);
    }
}

/* A large constant offset uses up the bits that the noise needs. */
static void note_coarse(const extent_t *extent, const quantisation_t *quantisation)
{
    const double largest = fmax(fabs(extent->low), fabs(extent->high));
    const double resolution = (quantisation->number == DAVAR_PORT_F32)
                                  ? largest * (double)FLT_EPSILON
                                  : quantisation->step;
    const double span = extent->high - extent->low;
    if ((span > 0.0) && (span < COARSE_LEVELS * resolution) && (span < 0.5 * largest)) {
        (void)fprintf(stderr,
                      "davar-sim: note: the values differ by only %.3g, and the arithmetic "
                      "resolves only %.3g: subtract a constant from the column first\n",
                      span, resolution);
    }
}

static bool any_counts(const selection_t *selection)
{
    for (size_t c = 0; c < selection->count; c++) {
        if (selection->unit[c] == UNIT_COUNTS) {
            return true;
        }
    }
    return false;
}

static void note_unused(const char *option, const char *why)
{
    (void)fprintf(stderr, "davar-sim: note: --%s is not used: %s\n", option, why);
}

static void note_unused_options(const options_t *options, const selection_t *selection)
{
    const bool is_float = (options->arith == ARITH_FLOAT);
    if (is_float && (options->setup.lsb > 0.0) && !any_counts(selection)) {
        note_unused("lsb", "--arith float uses the values unchanged");
    }
    if ((options->bits > 0U) && (is_float || !(options->setup.lsb > 0.0))) {
        note_unused("bits",
                    is_float ? "--arith float has no counts" : "without --lsb counts have 32 bits");
    }
    if ((options->setup.law != DAVAR_LAW_ID_GLR) &&
        ((options->setup.false_alarms_per_hour > 0.0) || (options->setup.cut_interval_s > 0.0) ||
         options->setup.block.given || options->setup.shock_blocks.given)) {
        note_unused("false-alarms-per-hour, --cut-interval, --block or --shock-blocks",
                    "only --law glr uses it");
    }
    if ((options->full_scale > 0.0) && !is_float) {
        note_unused("full-scale", "only --arith float uses it");
    }
}

static void note_timing(const options_t *options, const timing_t *timing)
{
    if (!timing_is_doubtful(timing)) {
        return;
    }
    const double share = 100.0 * (double)timing->gaps / (double)timing->steps;
    (void)fprintf(stderr, "davar-sim: note: %s: %.6g Hz from the median time step",
                  options->recording, timing->rate_hz);
    if (timing->mean_rate_hz > 0.0) {
        (void)fprintf(stderr, ", %.6g Hz on average", timing->mean_rate_hz);
    }
    (void)fprintf(stderr,
                  ", %" PRIu64 " gaps (%.2g %% of the steps); if the samples are evenly spaced but "
                  "their time stamps are not, give --rate",
                  timing->gaps, share);
    if (timing->mean_rate_hz > 0.0) {
        (void)fprintf(stderr, " %.4g", timing->mean_rate_hz);
    }
    (void)fputc('\n', stderr);
}

static void note_contradiction(const timing_t *timing)
{
    if (timing_is_contradicted(timing)) {
        (void)fprintf(stderr,
                      "davar-sim: note: using --rate %.6g, but the time stamps give %.6g Hz\n",
                      timing->rate_hz, timing->stamped_hz);
    }
}

void report_notes(const options_t *options, const recording_t *recording, const timing_t *timing,
                  const quantisation_t *quantisation)
{
    note_units(&recording->selection);
    note_scale(options, quantisation);
    if (!(options->setup.lsb > 0.0)) {
        note_coarse(&recording->extent, quantisation);
    }
    note_unused_options(options, &recording->selection);
    note_timing(options, timing);
    note_contradiction(timing);
}

void report_torn(const selection_t *selection, const uint64_t *torn)
{
    for (size_t c = 0; c < selection->count; c++) {
        (void)fprintf(stderr, "davar-sim: %s: %" PRIu64 " torn register reads skipped\n",
                      selection->name[c], torn[c]);
    }
}

void report_learned(const selection_t *selection, const learned_t *learned, double rate_hz)
{
    for (size_t c = 0; c < selection->count; c++) {
        char text[LEARN_TEXT];
        char option[LEARN_TEXT];
        learn_describe(&learned[c], rate_hz, text);
        learn_option(&learned[c], option);
        (void)fprintf(stderr, "davar-sim: %s: %s, from %zu segments of %zu samples%s%s\n",
                      selection->name[c], text, learned[c].segments, learned[c].segment,
                      (option[0] != '\0') ? "; to declare it: --bandwidth " : "", option);
    }
}

void report_counters(const davar_health_t *health)
{
    if ((health->gaps | health->missing | health->saturated | health->not_finite |
         health->restarts | health->missed) == 0U) {
        return;
    }
    (void)fprintf(stderr,
                  "davar-sim: %" PRIu32 " gaps (%" PRIu32 " samples missing), %" PRIu32
                  " samples saturated, %" PRIu32 " windows restarted, %" PRIu32 " results missed\n",
                  health->gaps, health->missing, health->saturated, health->restarts,
                  health->missed);
}

void report_coarse(uint64_t coarse, uint64_t rows)
{
    if (coarse > 0U) {
        (void)fprintf(stderr,
                      "davar-sim: note: %" PRIu64 " of %" PRIu64
                      " results: the noise, or its step from sample to sample, is below half a "
                      "count, so rounding hides the angle random walk; record with a finer count "
                      "(--details shows its upper limit)\n",
                      coarse, rows);
    }
}

void report_unreached(const uint32_t *taus, uint8_t count, uint8_t reached)
{
    if (reached < count) {
        const uint32_t m = taus[reached];
        (void)fprintf(stderr,
                      "davar-sim: note: no result has clusters of %" PRIu32
                      " samples or more: they "
                      "need about %" PRIu64 " samples without a gap before the last result. Use a "
                      "longer recording or a smaller --longest-tau\n",
                      m, 2U * (uint64_t)m);
    }
}

void report_filtered(uint64_t filtered, uint64_t rows, bool declared)
{
    if ((filtered * FEW) > rows) {
        (void)fprintf(
            stderr, "davar-sim: note: %" PRIu64 " of %" PRIu64 " results withheld: %s\n", filtered,
            rows,
            declared ? "the short cluster sizes contradict the filter of --bandwidth. To learn it "
                       "from a recording at rest, give --bandwidth auto. A vibration tone has the "
                       "same effect"
                     : "the short cluster sizes read low, as after a low-pass. Give the filter "
                       "of the data sheet (--bandwidth HZ[:ORDER]); or auto, to learn it from a "
                       "recording at rest; or none");
    }
}
