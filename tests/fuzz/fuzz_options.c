/* davar tests - any words as options of davar-sim. They are rejected with one line, or accepted.
 * The library then accepts the resulting configuration, or rejects it with a line that names an
 * option. */
#include "davar/davar.h"
#include "fuzzing.h"
#include "instances/settings.h"

#include <ctype.h>
#include <getopt.h>
#include <math.h>
#include <string.h>

#define WORDS_MAX 40
#define BYTES_MAX 1024U

static void check_message(const sim_error_t *error)
{
    REQUIRE(error->text[0] != '\0');
    for (const char *c = error->text; *c != '\0'; c++) {
        REQUIRE(!iscntrl((unsigned char)*c));
    }
}

static bool is_positive_or_absent(double value)
{
    return isfinite(value) && (value >= 0.0);
}

static void check_ranges(const options_t *options)
{
    REQUIRE(options->recording != NULL);
    REQUIRE((options->column_count <= OPTIONS_COLUMNS_MAX) &&
            (options->setup.tau_count <= DAVAR_TAUS_MAX));
    REQUIRE(is_positive_or_absent(options->setup.rate_hz) &&
            is_positive_or_absent(options->setup.lsb) &&
            is_positive_or_absent(options->full_scale) && is_positive_or_absent(options->pace) &&
            is_positive_or_absent(options->setup.false_alarms_per_hour));
    REQUIRE((options->gap_factor > 1.0) || !(options->gap_factor > 0.0));
    REQUIRE((options->setup.law >= DAVAR_LAW_ID_FIXED) && (options->setup.law <= DAVAR_LAW_ID_GLR));
    REQUIRE(!options->setup.kurtosis.given ||
            (options->setup.kurtosis.low <= options->setup.kurtosis.high));
    REQUIRE(!options->setup.contribution.given ||
            (options->setup.contribution.low <= options->setup.contribution.high));
}

/* Runs davar-sim up to the point where it reads the recording. */
static void configure(const options_t *options)
{
    static settings_t settings;
    sim_error_t error = {{0}};
    check_ranges(options);
    if (!settings_make(&settings, options, &error) || !settings_check(&settings, options, &error)) {
        check_message(&error);
        REQUIRE(strncmp(error.text, "--", 2U) == 0);
        return;
    }
    davar_config_t config = settings.config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.full_scale = 100.0;
    const size_t bytes = (options->arith == ARITH_FLOAT)
                             ? davar_memory_size_f32(&config)
                             : (davar_memory_size_q15(&config) + davar_memory_size_q31(&config));
    REQUIRE(bytes > 0U);
    REQUIRE(settings_samples_needed(&settings) > 0U);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char text[BYTES_MAX + 1U];
    static char program[] = "davar-sim";
    char *words[WORDS_MAX + 2] = {program};
    int count = 1;
    if (size > BYTES_MAX) {
        return 0;
    }
    memcpy(text, data, size);
    text[size] = '\0';
    for (char *rest = text; (rest != NULL) && (count <= WORDS_MAX); count++) {
        words[count] = strsep(&rest, "\n");
    }
    words[count] = NULL;
    options_t options;
    sim_error_t error = {{0}};
    optind = 0; /* getopt restarts, even inside a word */
    switch (options_parse(&options, count, words, &error)) {
    case COMMAND_BAD:
        check_message(&error);
        break;
    case COMMAND_RUN:
        configure(&options);
        break;
    case COMMAND_HELP:
    case COMMAND_VERSION:
    default:
        break;
    }
    options_free(&options);
    return 0;
}
