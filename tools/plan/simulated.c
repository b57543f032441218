/* davar - runs a setup of tools/davar-plan on the noise that it was planned for, on the host; compiled
 * with davar_setup.c by planner/simulate.py.
 *
 *   simulated FILTER NOISE UNIT WINDOWS CHANGES SEED
 *
 * FILTER: as davar-plan --bandwidth; "-": none. NOISE: angle random walk of the samples, deg/sqrt(h).
 * UNIT: deg/s of a count; 1 for floats. WINDOWS: of all axes together. CHANGES: doublings of the
 * noise. Prints lines "name value": shares of the results with an angle random walk, and of these
 * whose interval contains NOISE, at rest and in motion, and the same of floors (FLOOR); half the median interval in percent for each; samples
 * from a change until its alarm (law glr) or until a result of the new noise alone, which nine in
 * ten do not exceed. SAMPLE: type of a sample. */
#include "davar_setup.h"
#include "draw.h"
#include "filtered.h"
#include "setup/bandwidth.h"

#ifdef GLR
#include "davar/glr.h"
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.141592653589793
#define LATEST 64.0 /* windows, after which a change is missed */
#define MOVING_HZ 0.5
#define MOVING_DPS 5.0

/* --- the gyro --- */

static davar_filter_t filter;
static filtered_t axes[DAVAR_SETUP_AXES];
static double sigma; /* of a sample of white noise before the filter, in counts */
static double unit;
static uint64_t moving; /* samples in motion so far; 0: at rest */

/* Pushes one sample of each axis, with noise `times` as strong. */
static void push(double times)
{
    static SAMPLE samples[DAVAR_SETUP_AXES];
    const double rate = DAVAR_SETUP_RATE_HZ;
    const double most = (sizeof(SAMPLE) == 2U) ? 20000.0 * unit : MOVING_DPS;
    const double size = (moving > 0U) ? ((most < MOVING_DPS) ? most : MOVING_DPS) / unit : 0.0;
    const double turn = size * sin(2.0 * PI * MOVING_HZ / rate * (double)moving);
    moving += (moving > 0U) ? 1U : 0U;
    for (unsigned x = 0U; x < DAVAR_SETUP_AXES; x++) {
        const double value = filtered_next(&axes[x], &filter, times * sigma * draw_gauss()) + turn;
        const double limit = (sizeof(SAMPLE) == 2U) ? 32767.0 : 2147483000.0;
        const double clipped = fmax(-limit, fmin(limit, rint(value)));
        samples[x] = (SAMPLE)((UNIT_IS_COUNT) ? clipped : value);
    }
    davar_setup_push(samples, 1U);
}

/* --- what comes out --- */

static void print_share(const char *name, double hits, double all)
{
    (void)printf("%s %.4f\n", name, (all > 0.0) ? (hits / all) : (double)NAN);
}

static struct {
    double results; /* of full windows */
    double present;
    double holds;
} floors;

/* Counts the floor of an axis, if there is a new one. */
static void count_floor(uint8_t axis, double truth)
{
#ifdef FLOOR
    const davar_floor_result_t *const floor = davar_setup_floor(axis);
    if ((floor != NULL) && (floor->why != DAVAR_FLOOR_FILLING)) {
        const bool is_present = (floor->why == DAVAR_FLOOR_VALUE);
        const bool holds =
            is_present && ((double)floor->low <= truth) && (truth <= (double)floor->high);
        floors.results += 1.0;
        floors.present += is_present ? 1.0 : 0.0;
        floors.holds += holds ? 1.0 : 0.0;
    }
#else
    (void)axis;
    (void)truth;
#endif
}

/* Results of full windows. */
static void run(const char *name, uint64_t windows, double truth)
{
    const davar_config_t *const config = davar_setup_config();
    const uint64_t each = (windows / DAVAR_SETUP_AXES) + 1U;
    const uint64_t count = each * config->window.longest;
    double *const half = malloc(DAVAR_SETUP_AXES * (count / config->stride + 1U) * sizeof *half);
    size_t present = 0U;
    double results = 0.0;
    double holds = 0.0;
    if (half == NULL) {
        exit(1);
    }
    for (uint64_t i = 0U; i < (count + config->window.longest); i++) {
        push(1.0);
        for (uint8_t x = 0U; x < DAVAR_SETUP_AXES; x++) {
            const davar_result_t *const result = davar_setup_take(x);
            count_floor(x, truth);
            if ((result == NULL) || (i < config->window.longest)) {
                continue;
            }
            const davar_coefficient_t *const walk = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
            results += 1.0;
            if (walk->present) {
                half[present++] = 50.0 * (walk->high - walk->low) / walk->value;
                holds += ((walk->low <= truth) && (truth <= walk->high)) ? 1.0 : 0.0;
            }
        }
    }
    char line[32];
    (void)snprintf(line, sizeof line, "%spresent", name);
    print_share(line, (double)present, results);
    (void)snprintf(line, sizeof line, "%sholds", name);
    print_share(line, holds, (double)present);
    (void)printf("%sarw_percent %.4g\n", name, draw_quantile(half, present, 0.5));
    free(half);
}

/* Has the change after `before` samples shown in this result of the first axis? */
static bool shows(const davar_result_t *result, uint64_t before)
{
#ifdef GLR
    davar_glr_report_t report;
    davar_glr_report(davar_setup_instance(0), &report);
    (void)result;
    (void)before;
    return report.alarm;
#else
    return result->epoch + 1U >= before + result->window_samples;
#endif
}

static double delay(void)
{
    const davar_config_t *const config = davar_setup_config();
    const uint64_t quiet =
        (3U * (uint64_t)config->window.longest / 2U) + (uint64_t)(draw_uniform() * config->stride);
    const double latest = LATEST * (double)config->window.longest;
    double late = 0.0;
    davar_setup_restart();
    for (uint64_t i = 0U; i < quiet; i++) {
        push(1.0);
        for (uint8_t x = 0U; x < DAVAR_SETUP_AXES; x++) {
            const davar_result_t *const result = davar_setup_take(x);
            (void)((x == 0U) && (result != NULL) && shows(result, 0U));
        }
    }
    for (;;) {
        push(2.0);
        late += 1.0;
        const davar_result_t *const result = davar_setup_take(0);
        if (((result != NULL) && shows(result, quiet)) || (late > latest)) {
            return late;
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 7) {
        return 2;
    }
    const double noise = strtod(argv[2], NULL);
    const size_t changes = (size_t)strtoull(argv[5], NULL, 10);
    double *const late = malloc((changes + 1U) * sizeof *late);
    unit = strtod(argv[3], NULL);
    draw_state = strtoull(argv[6], NULL, 10);
    if ((late == NULL) || ((strcmp(argv[1], "-") != 0) && (strcmp(argv[1], "none") != 0) &&
                           (bandwidth_read(argv[1], DAVAR_SETUP_RATE_HZ, &filter) != NULL))) {
        return 1;
    }
    filtered_normalise(&filter);
    for (unsigned x = 0U; x < DAVAR_SETUP_AXES; x++) {
        if (!filtered_start(&axes[x], &filter)) {
            return 1;
        }
    }
    sigma = noise / 60.0 * sqrt(DAVAR_SETUP_RATE_HZ) / unit;
    if (davar_setup_start() != DAVAR_OK) {
        return 1;
    }
    run("", strtoull(argv[4], NULL, 10), noise);
    print_share("floor_present", floors.present, floors.results);
    print_share("floor_holds", floors.holds, floors.present);
    for (size_t i = 0U; i < changes; i++) {
        late[i] = delay();
    }
    (void)printf("respond_samples %.9g\n", draw_quantile(late, changes, 0.9));
#ifdef MOVING
    moving = 1U;
    davar_setup_restart();
    run("moving_", strtoull(argv[4], NULL, 10) / 4U, noise);
#endif
    return 0;
}
