/* davar-plan - writes the plan of a fit for a list of cluster sizes and a filter as C, or the plan of
 * a floor. The library itself computes the plan. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/floor.h"
#include "davar/small.h"
#include "setup/bandwidth.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TAU_MAX 8388608U            /* half of the longest possible window */
#define CASCADE_TAU_MAX 2147483648U /* of a cascade */

static const char usage[] =
    "usage: davar-plan --taus M,M,... [--long M,M,...] [--bandwidth FILTER --rate HZ] [--name "
    "NAME]\n"
    "       davar-plan --taus 1,2,4,... --window N --stride K --rate HZ --lsb X --bandwidth "
    "FILTER\n"
    "                  [--name NAME]\n"
    "       davar-plan --floor --rate HZ --lsb X --bandwidth FILTER [--rail N] [--name NAME]\n"
    "\n"
    "The first form writes a davar_plan_t for davar_fit, davar_fit_white and "
    "davar_fit_white_ready.\n"
    "A program that links it does not need davar_plan_init or davar_plan_init_filtered. The "
    "second\n"
    "form writes a constant davar_small_plan_t for davar/small.h: windows of N samples without "
    "gaps,\n"
    "and a result every K samples; N is a multiple of K. The third form writes a "
    "davar_floor_plan_t\n"
    "for davar_floor_push and davar_floor_take. A program that links it does not need\n"
    "davar_floor_plan.\n"
    "\n"
    "  --taus M,M,...      all cluster sizes of the configuration, in samples, ascending\n"
    "  --long M,M,...      cluster sizes of a cascade, which davar_cascade_append adds\n"
    "  --floor             the plan of a floor, with blocks of 256 samples, below 800 Hz of 128\n"
    "  --window N          the length of a window, 9 times the largest cluster size to 65536\n"
    "  --stride K          samples between two results, 2 to half a window\n"
    "  --lsb X             size of a count in deg/s\n"
    "  --rail N            a count of this size, of either sign, is clipped (default 32767)\n"
    "  --bandwidth FILTER  what is between the gyro's noise and the samples. Without it, the fit\n"
    "                      withholds its result when the short cluster sizes read low, and there "
    "is\n"
    "                      no plan of a floor. One of:\n"
    "                        HZ[:ORDER[:PERCENT]]  an analogue low-pass of 1 or 2 poles (default\n"
    "                                              2), -3 dB at HZ, known to PERCENT (10)\n"
    "                        biquad:HZ  pt1:HZ  notch:HZ:Q\n"
    "                                              digital, at the sample rate\n"
    "                        average[ORDER]:N      ORDER (default 1) moving averages of N samples\n"
    "                        cic[ORDER]:N          the same, keeping every N-th sample\n"
    "                        sum:N                 the sums of N counts that davar_average makes\n"
    "                        ba:B0,B1,..[:A1,A2,..]  coefficients, with A0 = 1\n"
    "                        FILTER+FILTER         in series, in this order\n"
    "                        none                  no filter\n"
    "  --rate HZ           sample rate of the samples that davar gets; for a filter in Hz\n"
    "  --name NAME         name of the plan (default davar_ready_plan); declare it as\n"
    "                      extern davar_plan_t NAME; or extern const davar_floor_plan_t NAME;\n"
    "\n"
    "For sums of N counts (davar/average.h), divide --rate and --lsb of a count by N, multiply\n"
    "its --rail by N, and end --bandwidth with sum:N. For a sum with a sample at the rail, push\n"
    "INT32_MAX.\n"
    "\n"
    "  --help\n"
    "\n"
    "Exit status: 0 done, 2 bad option (one line on standard error, nothing on standard output).\n";

/* found: the value; null: there is none. */
static int reject(const char *option, const char *what, const char *found)
{
    (void)fprintf(stderr, "davar-plan: %s: %s", option, what);
    if (found != NULL) {
        (void)fprintf(stderr, ", found '%s'", found);
    }
    (void)fputc('\n', stderr);
    return 2;
}

static int reject_filter(const char *option, const char *expected, const char *text)
{
    (void)fprintf(stderr, "davar-plan: %s: expected %s, found '%s'\n", option, expected, text);
    return 2;
}

static bool is_name(const char *text)
{
    if ((*text == '\0') || (isdigit((unsigned char)*text) != 0)) {
        return false;
    }
    while ((isalnum((unsigned char)*text) != 0) || (*text == '_')) {
        text++;
    }
    return *text == '\0';
}

/* Reads ascending whole numbers separated by commas, after the first `count` of taus[] and at most
 * `most`. Returns the new count, or 0 on a bad list. */
static uint8_t read_taus(const char *text, unsigned long most, uint32_t taus[], uint8_t count)
{
    unsigned long before = (count > 0U) ? taus[count - 1U] : 0U;
    for (;;) {
        char *end;
        errno = 0;
        const unsigned long m = (isdigit((unsigned char)*text) != 0) ? strtoul(text, &end, 10) : 0U;
        if ((m <= before) || (m > most) || (errno != 0) || (count == DAVAR_TAUS_MAX)) {
            return 0U;
        }
        taus[count] = (uint32_t)m;
        count++;
        if (*end == '\0') {
            return count;
        }
        if (*end != ',') {
            return 0U;
        }
        before = m;
        text = end + 1;
    }
}

static void write_floats(const char *name, const float values[], int count)
{
    (void)printf("    .%s = {", name);
    for (int i = 0; i < count; i++) {
        (void)printf("%s%aF", (i > 0) ? ", " : "", (double)values[i]);
    }
    (void)printf("},\n");
}

static void write_row(const char *name, int k, const int32_t values[], int count)
{
    (void)printf("    .%s[%d] = {", name, k);
    for (int t = 0; t < count; t++) {
        (void)printf("%s%" PRId32, (t > 0) ? ", " : "", values[t]);
    }
    (void)printf("},\n");
}

static void write_rows(const davar_plan_t *plan)
{
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        write_row("white.functional", k, plan->white.functional[k], plan->white.count);
        write_row("variance", k, plan->variance[k], plan->white.count);
        (void)printf("    .variance_exponent[%d] = %d,\n", k, plan->variance_exponent[k]);
    }
}

static void write_numbers(const davar_plan_t *plan)
{
    (void)printf("    .white.declared = %s,\n    .white.sample = %aF,\n    .spread = %aF,\n    "
                 ".floor = %aF,\n"
                 "    .white.hidden = %aF,\n    .white.rounding_variance = %a,\n    .level = "
                 "%aF,\n    .white.step = %aF,\n",
                 plan->white.declared ? "true" : "false", (double)plan->white.sample,
                 (double)plan->spread, (double)plan->floor, (double)plan->white.hidden,
                 plan->white.rounding_variance, (double)plan->level, (double)plan->white.step);
    (void)printf("    .white.passed = %u,\n    .white.white_bits = %u,\n    .white.rounding = "
                 "%aF,\n    .white.coarse = %" PRIu32 "U,\n",
                 (unsigned)plan->white.passed, (unsigned)plan->white.white_bits,
                 (double)plan->white.rounding, plan->white.coarse);
    (void)printf("    .misfit_spread = %aF,\n    .white.misfit_limit = UINT64_C(%" PRIu64
                 "),\n};\n",
                 (double)plan->misfit_spread, plan->white.misfit_limit);
}

/* The detector's settings for a filter, as a comment to copy: a configuration cannot be in two
 * files. */
static void write_whitening(const davar_filter_t *filter)
{
    davar_config_t config = davar_default_config;
    davar_whiten(&config, filter);
    (void)printf("/* Law glr with this filter: .whiten_first = %d, .whiten_second = %d,\n"
                 " * .whiten_level = %.9g, .whiten_tolerance = %.3g, .block = %u\n"
                 " * in the glr part of the configuration, as davar_whiten sets them. */\n",
                 config.glr.whiten_first, config.glr.whiten_second, config.glr.whiten_level,
                 config.glr.whiten_tolerance, (unsigned)config.glr.block);
}

static void write_includes(const char *header)
{
    (void)printf("/* davar - a plan generated by tools/davar-plan. */\n#include "
                 "\"davar/%s.h\"\n#include \"davar/version.h\"\n\n",
                 header);
}

static void write_floor_plan(const davar_floor_plan_t *plan, const char *name)
{
    const int bins = (int)DAVAR_FLOOR_BINS;
    write_includes("floor");
    (void)printf("_Static_assert(DAVAR_VERSION == %d, \"run tools/davar-plan again\");\n\n",
                 DAVAR_VERSION);
    (void)printf("extern const davar_floor_plan_t %s;\n\nconst davar_floor_plan_t %s = {\n", name,
                 name);
    write_floats("weight", plan->weight, bins);
    write_floats("passed", plan->passed, bins);
    write_floats("doubt", plan->doubt, bins);
    (void)printf("    .unit = %aF,\n    .rail = %" PRId32
                 ",\n    .segments = %u,\n    .usable = %u,\n};\n",
                 (double)plan->unit, plan->rail, (unsigned)plan->segments, (unsigned)plan->usable);
}

static void write_plan(const davar_plan_t *plan, const char *name)
{
    const int count = plan->white.count;
    const int sizes = plan->sizes;
    const int terms = (int)DAVAR_COEFFICIENT_COUNT;
    write_includes("fit");
    (void)printf("_Static_assert((DAVAR_VERSION == %d) && (DAVAR_TAUS_MAX >= %d), \"run "
                 "tools/davar-plan again\");\n\n",
                 DAVAR_VERSION, sizes);
    (void)printf(
        "extern davar_plan_t %s;\n\ndavar_plan_t %s = {\n    .white.count = %d,\n    .sizes = "
        "%d,\n",
        name, name, count, sizes);
    write_floats("m", plan->m, sizes);
    write_floats("gain", plan->gain, sizes);
    write_floats("flicker", plan->flicker, sizes);
    write_floats("walk", plan->walk, sizes);
    write_floats("offset", plan->offset, sizes);
    write_floats("covariance", plan->covariance, (sizes * (sizes + 1)) / 2);
    write_floats("weight", plan->weight, sizes);
    write_floats("freedom", plan->freedom, sizes);
    write_floats("white.to_white", plan->white.to_white, count);
    write_floats("doubtful", plan->doubtful, count);
    (void)printf("    .white.inverse_gain = {");
    for (int t = 0; t < count; t++) {
        (void)printf("%s%" PRIu32 "U", (t > 0) ? ", " : "", plan->white.inverse_gain[t]);
    }
    (void)printf("},\n");
    write_rows(plan);
    write_floats("offset_variance", plan->offset_variance, terms);
    write_floats("scale", plan->scale, terms);
    write_floats("white.centre", plan->white.centre, terms);
    write_floats("unit", plan->unit, terms);
    write_floats("white.rounding_most", plan->white.rounding_most, terms);
    write_numbers(plan);
}

static void write_integers(const char *name, const uint32_t values[], int count)
{
    (void)printf("    .%s = {", name);
    for (int i = 0; i < count; i++) {
        (void)printf("%s%" PRIu32 "U", (i > 0) ? ", " : "", values[i]);
    }
    (void)printf("},\n");
}

/* What does not depend on the window. */
static void write_sizes(const davar_white_plan_t *plan)
{
    const int count = plan->count;
    (void)printf("    .fit.count = %d,\n    .fit.declared = %s,\n    .fit.passed = %u,\n    "
                 ".fit.white_bits = %u,\n",
                 count, plan->declared ? "true" : "false", (unsigned)plan->passed,
                 (unsigned)plan->white_bits);
    write_floats("fit.to_white", plan->to_white, count);
    write_integers("fit.inverse_gain", plan->inverse_gain, count);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        write_row("fit.functional", k, plan->functional[k], count);
    }
    write_floats("fit.centre", plan->centre, (int)DAVAR_COEFFICIENT_COUNT);
    write_floats("fit.rounding_most", plan->rounding_most, (int)DAVAR_COEFFICIENT_COUNT);
    (void)printf("    .fit.sample = %aF,\n    .fit.hidden = %aF,\n    .fit.step = %aF,\n    "
                 ".fit.rounding = %aF,\n    .fit.rounding_variance = %a,\n",
                 (double)plan->sample, (double)plan->hidden, (double)plan->step,
                 (double)plan->rounding, plan->rounding_variance);
    (void)printf("    .fit.coarse = %" PRIu32 "U,\n    .fit.misfit_limit = UINT64_C(%" PRIu64
                 "),\n",
                 plan->coarse, plan->misfit_limit);
}

/* What depends on the window and the rate. */
static void write_window(const davar_white_plan_t *plan)
{
    const int terms = (int)DAVAR_COEFFICIENT_COUNT;
    write_integers("fit.root_edf", plan->root_edf, plan->count);
    write_floats("fit.high", plan->high, plan->count);
    write_integers("fit.sigma", plan->sigma, terms);
    write_integers("fit.doubt", plan->doubt, terms);
    (void)printf("    .fit.unit = %a,\n    .fit.white_tails = %" PRIu32
                 "U,\n    .fit.white_low = %" PRIu32 "U,\n    .fit.white_high = %aF,\n",
                 plan->unit, plan->white_tails, plan->white_low, (double)plan->white_high);
}

/* What the command line asks for. */
typedef struct {
    uint32_t taus[DAVAR_TAUS_MAX];
    uint8_t tau_count; /* of the window; those of a cascade follow */
    uint8_t sizes;
    const char *long_taus; /* null: none */
    const char *name;
    const char *filter; /* null: undeclared */
    double rate_hz;     /* 0: not given */
    bool is_floor;
    uint32_t window; /* of davar_small_t, in samples; 0: not given */
    uint32_t stride;
    double lsb;    /* deg/s; 0: not given */
    uint32_t rail; /* 0: not given */
} request_t;

/* Reads a number above 0 that every plan can hold. Returns 0, or the exit status of an error. */
static int read_number(const char *option, const char *value, double *number)
{
    char *end = NULL;
    *number = strtod(value, &end);
    return ((*end == '\0') && (*number >= 1e-12) && (*number <= 1e12))
               ? 0
               : reject(option, "expected a number from 1e-12 to 1e12", value);
}

/* The same for a whole number. */
static int read_whole(const char *option, const char *value, uint32_t *number)
{
    char *end = NULL;
    errno = 0;
    const long count = (isdigit((unsigned char)*value) != 0) ? strtol(value, &end, 10) : 0;
    if ((count < 1) || (count > INT32_MAX) || (errno != 0) || (*end != '\0')) {
        return reject(option, "expected a whole number from 1 to 2147483647", value);
    }
    *number = (uint32_t)count;
    return 0;
}

/* Reads one option. Returns 0, or the exit status of an error. */
static int read_option(request_t *request, const char *option, const char *value)
{
    if (strcmp(option, "--taus") == 0) {
        request->tau_count = read_taus(value, TAU_MAX, request->taus, 0U);
        return (request->tau_count > 0U)
                   ? 0
                   : reject(option,
                            "expected 1 to 32 ascending whole numbers from 1 to 8388608, separated "
                            "by commas",
                            value);
    }
    if (strcmp(option, "--long") == 0) {
        request->long_taus = value;
        return 0;
    }
    if (strcmp(option, "--bandwidth") == 0) {
        request->filter = value;
        return 0;
    }
    if (strcmp(option, "--rate") == 0) {
        return read_number(option, value, &request->rate_hz);
    }
    if (strcmp(option, "--lsb") == 0) {
        return read_number(option, value, &request->lsb);
    }
    if (strcmp(option, "--rail") == 0) {
        return read_whole(option, value, &request->rail);
    }
    if (strcmp(option, "--window") == 0) {
        return read_whole(option, value, &request->window);
    }
    if (strcmp(option, "--stride") == 0) {
        return read_whole(option, value, &request->stride);
    }
    if (strcmp(option, "--name") == 0) {
        request->name = value;
        return is_name(value) ? 0 : reject(option, "expected a C identifier", value);
    }
    return reject(option, "unknown option (see --help)", value);
}

/* Adds the sizes of a cascade. Returns 0, or the exit status of an error. */
static int add_long_taus(request_t *request)
{
    request->sizes = request->tau_count;
    if (request->long_taus != NULL) {
        request->sizes =
            read_taus(request->long_taus, CASCADE_TAU_MAX, request->taus, request->tau_count);
    }
    return (request->sizes > 0U) ? 0
                                 : reject("--long",
                                          "expected ascending whole numbers above those of --taus, "
                                          "up to 2147483648, and at most 32 with them",
                                          request->long_taus);
}

/* Solves a plan for the sizes, the length and the rate of the window, as the first fit of a result
 * does. */
static void solve_for_window(davar_plan_t *plan, const request_t *request, uint32_t window,
                             double rate_hz)
{
    static davar_result_t result;
    result.tau_count = request->tau_count;
    result.window_samples = window;
    result.unit_per_count = 1.0;
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        const uint32_t m = request->taus[t];
        result.tau[t] = (davar_adev_t){.m = m, .differences = window + 1U - (2U * m), .adev = 1.0};
    }
    (void)davar_fit_white(plan, rate_hz, &result);
}

/* Writes the constant plan of davar_small_t. Returns 0, or the exit status of an error. */
static int write_small(davar_plan_t *plan, const request_t *request)
{
    const uint32_t window = request->window;
    const uint32_t stride = request->stride;
    const bool fits = (stride >= 2U) && (window <= 65536U) && ((window % stride) == 0U) &&
                      (window > stride) && (request->sizes == request->tau_count) &&
                      (request->taus[request->tau_count - 1U] <= (window / 9U));
    if ((request->rate_hz <= 0.0) || (request->lsb <= 0.0) || (request->filter == NULL)) {
        return reject("--window", "needs --stride, --rate, --lsb and --bandwidth", NULL);
    }
    for (uint8_t t = 0U; t < request->tau_count; t++) {
        if (!fits || (request->taus[t] != (UINT32_C(1) << t))) {
            return reject("--window", "not with these --taus and --stride (see --help)", NULL);
        }
    }
    solve_for_window(plan, request, window, request->rate_hz);
    write_includes("small");
    (void)printf("_Static_assert((DAVAR_VERSION == %d) && (DAVAR_TAUS_MAX >= %d), \"run "
                 "tools/davar-plan again\");\n\n",
                 DAVAR_VERSION, request->sizes);
    (void)printf("extern const davar_small_plan_t %s;\n\nconst davar_small_plan_t %s = {\n",
                 request->name, request->name);
    write_sizes(&plan->white);
    write_window(&plan->white);
    (void)printf("    .unit_per_count = %a,\n    .fit.window = %" PRIu32 ",\n    .stride = %" PRIu32
                 ",\n};\n",
                 request->lsb, window, stride);
    return 0;
}

/* Reads the filter of the request. Returns 0, or the exit status of an error. */
static int read_filter(const request_t *request, davar_filter_t *filter)
{
    const bool has_rate = (request->rate_hz > 0.0);
    const char *expected = bandwidth_read(request->filter, 0.0, filter);
    if ((expected == NULL) && !has_rate && bandwidth_has_hz(request->filter)) {
        return reject("--rate", "required with a frequency in --bandwidth (see --help)", NULL);
    }
    if (expected == NULL) {
        expected = bandwidth_read(request->filter, has_rate ? request->rate_hz : 1.0, filter);
    }
    return (expected == NULL) ? 0 : reject_filter("--bandwidth", expected, request->filter);
}

/* Makes and writes the plan of a fit. Returns 0, or the exit status of an error. */
static int plan_fit(request_t *request)
{
    static davar_plan_t plan;
    davar_filter_t filter;
    if (request->tau_count == 0U) {
        return reject("--taus", "required (see --help)", NULL);
    }
    if (((request->lsb > 0.0) && (request->window == 0U)) || (request->rail > 0U)) {
        return reject((request->rail > 0U) ? "--rail" : "--lsb", "only with --floor", NULL);
    }
    if ((request->stride > 0U) && (request->window == 0U)) {
        return reject("--stride", "only with --window", NULL);
    }
    int status = add_long_taus(request);
    if ((status == 0) && (request->filter != NULL)) {
        status = read_filter(request, &filter);
    }
    if (status != 0) {
        return status;
    }
    if (request->filter == NULL) {
        davar_plan_init(&plan, request->taus, request->sizes);
    } else {
        davar_plan_init_filtered(&plan, request->taus, request->sizes, &filter);
    }
    if (request->window > 0U) {
        return write_small(&plan, request);
    }
    if (request->sizes > request->tau_count) {
        solve_for_window(&plan, request, 9U * request->taus[request->tau_count - 1U], 1.0);
    }
    write_plan(&plan, request->name);
    if (request->filter != NULL) {
        write_whitening(&filter);
    }
    return 0;
}

/* The same for the plan of a floor. */
static int plan_floor(const request_t *request)
{
    davar_filter_t filter;
    davar_floor_plan_t plan;
    if ((request->tau_count > 0U) || (request->long_taus != NULL)) {
        return reject("--floor", "not with --taus and --long", NULL);
    }
    if ((request->rate_hz <= 0.0) || (request->lsb <= 0.0)) {
        return reject((request->rate_hz <= 0.0) ? "--rate" : "--lsb", "required (see --help)",
                      NULL);
    }
    if (request->filter == NULL) {
        return reject("--bandwidth", "required: give FILTER, or none for raw samples", NULL);
    }
    const int status = read_filter(request, &filter);
    if (status != 0) {
        return status;
    }
    const davar_floor_config_t config = {.rate_hz = request->rate_hz,
                                         .unit_per_count = request->lsb,
                                         .rail =
                                             (request->rail > 0U) ? (int32_t)request->rail : 32767,
                                         .filter = &filter};
    const davar_floor_status_t made = davar_floor_plan(&plan, &config);
    if (made != DAVAR_FLOOR_OK) {
        return reject("--floor", davar_floor_status_text(made), NULL);
    }
    write_floor_plan(&plan, request->name);
    if (plan.usable < DAVAR_FLOOR_NEEDED) {
        (void)fprintf(stderr,
                      "davar-plan: this floor has no value: the filter leaves %u usable "
                      "frequencies of %u, and a value needs %u\n",
                      (unsigned)plan.usable, DAVAR_FLOOR_BINS, DAVAR_FLOOR_NEEDED);
    }
    return 0;
}

/* Reads all options. Returns 0, or the exit status of an error. */
static int read_options(request_t *request, int count, char *words[])
{
    int status = 0;
    for (int i = 1; (i < count) && (status == 0); i++) {
        char *const option = words[i];
        if (strcmp(option, "--floor") == 0) {
            request->is_floor = true;
            continue;
        }
        char *const equals = strchr(option, '=');
        if (equals != NULL) {
            *equals = '\0';
        } else {
            i++;
        }
        const char *const value = (equals != NULL) ? (equals + 1) : words[i]; /* null: missing */
        status = (value != NULL)
                     ? read_option(request, option, value)
                     : reject(option, "unknown option, or its value is missing (see --help)", NULL);
    }
    return status;
}

int main(int count, char *words[])
{
    request_t request = {.name = "davar_ready_plan"};
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--help") == 0) {
            return (fputs(usage, stdout) < 0) ? 2 : 0;
        }
    }
    int status = read_options(&request, count, words);
    if (status == 0) {
        status = request.is_floor ? plan_floor(&request) : plan_fit(&request);
    }
    return ((status == 0) && (fflush(stdout) != 0)) ? 2 : status;
}
