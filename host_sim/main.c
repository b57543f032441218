/* davar-sim - runs recorded data through the library: command line in, exit status out. */
#include "common/stop.h"
#include "options/options.h"
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

static bool run(int argc, char **argv, sim_error_t *error)
{
    options_t options;
    const command_status_t status = options_parse(&options, argc, argv, error);
    const bool good = (status == COMMAND_RUN) ? simulate(&options, error)
                                              : command_show(&options_command, status, error);
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
