/* davar-sim - signals. Hazard: system calls are not restarted, so that one that waits for ever ends too. */
#include "common/stop.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t caught;

static void note(int number)
{
    caught = number;
}

void stop_catch(void)
{
    static const int SIGNALS[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE, SIGALRM,
                                  SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};
    struct sigaction action = {.sa_handler = note, .sa_flags = (int)SA_RESETHAND};
    (void)sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
        struct sigaction before;
        if ((sigaction(SIGNALS[i], NULL, &before) == 0) && (before.sa_handler == SIG_DFL)) {
            (void)sigaction(SIGNALS[i], &action, NULL);
        }
    }
}

bool stop_asked(sim_error_t *error)
{
    return (caught != 0) && !sim_fail(error, "stopped by signal %d", (int)caught);
}

void stop_die(void)
{
    if (caught != 0) {
        (void)raise(caught);
    }
}
