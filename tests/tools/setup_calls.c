/* davar tests - the results of a setup of tools/davar-plan with a curve, whatever the order of the
 * calls of take and curve.
 *
 *   setup_calls SEED SAMPLES
 *
 * STRIDE: of the setup. White noise, sigma SIGMA counts. After SAMPLES samples of every axis, calls
 * take and curve in several orders. Prints for each call whether it returned a result, and for each
 * curve its cluster sizes. */
#include "davar_setup.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define SIGMA 20.0

static uint64_t state;

/* Sum of twelve uniform variates. */
static int16_t noise(void)
{
    double sum = -6.0;
    for (int k = 0; k < 12; k++) {
        state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
        sum += (double)(state >> 11U) / 9007199254740992.0;
    }
    return (int16_t)((SIGMA * sum) + 1000.5);
}

static void push(uint32_t count)
{
    int16_t samples[DAVAR_SETUP_AXES];
    for (uint32_t i = 0U; i < count; i++) {
        for (size_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
            samples[a] = noise();
        }
        davar_setup_push(samples, 1U);
    }
}

static void print_call(const char *name, const davar_result_t *result)
{
    (void)printf("{\"call\": \"%s\", \"has_result\": %s", name,
                 (result != NULL) ? "true" : "false");
    if (result != NULL) {
        const davar_coefficient_t *const walk = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
        (void)printf(
            ", \"walk\": {\"present\": %s, \"value\": %.17g, \"low\": %.17g, \"high\": %.17g}",
            walk->present ? "true" : "false", walk->present ? walk->value : 0.0,
            walk->present ? walk->low : 0.0, walk->present ? walk->high : 0.0);
        (void)printf(", \"taus\": [");
        for (uint8_t t = 0U; t < result->tau_count; t++) {
            const davar_adev_t *const tau = &result->tau[t];
            (void)printf("%s[%" PRIu32 ", %" PRIu32 ", \"%a\", \"%a\", \"%a\"]",
                         (t > 0U) ? ", " : "", tau->m, tau->differences, tau->adev, tau->low,
                         tau->high);
        }
        (void)printf("]");
    }
    (void)printf("}\n");
}

static void take(uint8_t axis)
{
    print_call("take", davar_setup_take(axis));
}

static void curve(uint8_t axis)
{
    print_call("curve", davar_setup_curve(axis));
}

int main(int count, char *words[])
{
    if (count != 3) {
        return 2;
    }
    state = strtoull(words[1], NULL, 10);
    if (davar_setup_start() != DAVAR_OK) {
        return 1;
    }
    take(0U); /* before any sample */
    curve(0U);
    push((uint32_t)strtoul(words[2], NULL, 10));
    take(DAVAR_SETUP_AXES); /* no such axis */
    curve(DAVAR_SETUP_AXES);
    take(0U);
    take(0U);
    curve(0U);
    curve(0U);
    curve(1U); /* another axis, whose result still waits */
    take(1U);
    push(STRIDE); /* the next result */
    curve(0U);
    take(0U);
    return 0;
}
