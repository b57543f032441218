/* davar-sim - runs recorded data through the library: command line in, exit status out. */
#include "common/stop.h"
#include "options/options.h"
#include "options/usage.h"
#include "simulate.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define EXIT_BAD_INPUT 2

/* If a standard stream is closed, the next file opened would get its descriptor. */
static bool check_streams(sim_error_t *error)
{
    if (fcntl(STDOUT_FILENO, F_GETFD) < 0) {
        return sim_fail(error, "standard output: %s", strerror(errno));
    }
    while ((fcntl(STDIN_FILENO, F_GETFD) < 0) || (fcntl(STDERR_FILENO, F_GETFD) < 0)) {
        if (open("/dev/null", O_RDWR) < 0) {
            return sim_fail(error, "/dev/null: %s", strerror(errno));
        }
    }
    return true;
}

static bool print_text(void (*print)(FILE *file), sim_error_t *error)
{
    print(stdout);
    return (fflush(stdout) == 0) || sim_fail(error, "standard output: %s", strerror(errno));
}

static bool run(int argc, char **argv, sim_error_t *error)
{
    options_t options;
    bool good = false;
    switch (options_parse(&options, argc, argv, error)) {
    case OPTIONS_HELP:
        good = print_text(usage_print, error);
        break;
    case OPTIONS_VERSION:
        good = print_text(version_print, error);
        break;
    case OPTIONS_RUN:
        good = simulate(&options, error);
        break;
    case OPTIONS_BAD:
    default:
        break;
    }
    options_free(&options);
    return good;
}

int main(int argc, char **argv)
{
    sim_error_t error = {{0}};
    const bool good = check_streams(&error) && run(argc, argv, &error);
    stop_die();
    if (good) {
        return EXIT_SUCCESS;
    }
    (void)fprintf(stderr, "davar-sim: %s\n", error.text);
    return EXIT_BAD_INPUT;
}
