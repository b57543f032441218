/* davar-plan - writes the plan of a fit for a list of cluster sizes as C, made by the library's own
 * davar_plan_init. */
#include "davar/davar.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TAU_MOST 8388608U /* half of the longest window that there is */

static const char usage[] =
    "usage: davar-plan --taus M,M,... [--name NAME] > plan.c\n\n"
    "Writes a davar_plan_t for davar_fit_white_ready: a program that links it has no need of "
    "davar_plan_init.\n\n"
    "  --taus M,M,...   cluster sizes in samples, ascending: all that the configuration has\n"
    "  --name NAME      of the plan (default davar_ready_plan); declare it as extern davar_plan_t "
    "NAME;\n"
    "  --help\n\n"
    "Exit status: 0 done, 2 a bad option (one line on standard error, nothing on standard "
    "output).\n";

static int refuse(const char *option, const char *what, const char *text)
{
    (void)fprintf(stderr, "davar-plan: %s: %s, found '%s'\n", option, what, text);
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

/* Ascending whole numbers with commas between. 0: they are not. */
static uint8_t read_taus(const char *text, uint32_t taus[])
{
    uint8_t count = 0U;
    unsigned long before = 0U;
    for (;;) {
        char *end;
        errno = 0;
        const unsigned long m = (isdigit((unsigned char)*text) != 0) ? strtoul(text, &end, 10) : 0U;
        if ((m <= before) || (m > TAU_MOST) || (errno != 0) || (count == DAVAR_TAUS_MAX)) {
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
        write_row("functional", k, plan->functional[k], plan->count);
        write_row("variance", k, plan->variance[k], plan->count);
        (void)printf("    .variance_exponent[%d] = %d,\n", k, plan->variance_exponent[k]);
    }
}

static void write_plan(const davar_plan_t *plan, const char *name)
{
    (void)printf("/* davar - a plan that tools/davar-plan has written. */\n#include "
                 "\"davar/fit.h\"\n#include "
                 "\"davar/version.h\"\n\n");
    (void)printf("_Static_assert((DAVAR_VERSION == %d) && (DAVAR_TAUS_MAX >= %d), \"run "
                 "tools/davar-plan again\");\n\n",
                 DAVAR_VERSION, plan->count);
    (void)printf("extern davar_plan_t %s;\n\ndavar_plan_t %s = {\n    .count = %d,\n", name, name,
                 plan->count);
    write_floats("m", plan->m, plan->count);
    write_floats("weight", plan->weight, plan->count);
    write_floats("freedom", plan->freedom, plan->count);
    write_rows(plan);
    write_floats("scale", plan->scale, (int)DAVAR_COEFFICIENT_COUNT);
    write_floats("centre", plan->centre, (int)DAVAR_COEFFICIENT_COUNT);
    write_floats("unit", plan->unit, (int)DAVAR_COEFFICIENT_COUNT);
    (void)printf("    .misfit_spread = %aF,\n    .misfit_limit = UINT64_C(%" PRIu64 "),\n};\n",
                 (double)plan->misfit_spread, plan->misfit_limit);
}

int main(int count, char *words[])
{
    static davar_plan_t plan;
    uint32_t taus[DAVAR_TAUS_MAX];
    uint8_t tau_count = 0U;
    const char *name = "davar_ready_plan";
    for (int i = 1; i < count; i += 2) {
        const char *const value = words[i + 1]; /* null behind the last */
        if (strcmp(words[i], "--help") == 0) {
            return (fputs(usage, stdout) < 0) ? 2 : 0;
        }
        if (value == NULL) {
            return refuse(words[i], "an option of davar-plan with its value (--help)", "");
        }
        if (strcmp(words[i], "--taus") == 0) {
            tau_count = read_taus(value, taus);
            if (tau_count == 0U) {
                return refuse(words[i],
                              "1 to 32 ascending whole numbers with commas between, 1 to 8388608",
                              value);
            }
        } else if (strcmp(words[i], "--name") == 0) {
            name = value;
            if (!is_name(name)) {
                return refuse(words[i], "a name of C", value);
            }
        } else {
            return refuse(words[i], "not an option of davar-plan (--help)", value);
        }
    }
    if (tau_count == 0U) {
        return refuse("--taus", "must be given (--help)", "");
    }
    davar_plan_init(&plan, taus, tau_count);
    write_plan(&plan, name);
    return (fflush(stdout) == 0) ? 0 : 2;
}
