/* davar-sim - signals. Hazard: system calls are not restarted, so that a call that waits
 * indefinitely also ends. If the program does not call stop_requested() in time, one of two
 * timers ends it. One counts processor time and ends work that never ends. The other counts real
 * time and ends a wait for a reader that never reads. */
#include "common/stop.h"

#include <signal.h>
#include <stddef.h>
#include <sys/time.h>
#include <unistd.h>

static volatile sig_atomic_t caught;

#define WORK_S 1      /* of processor time; a row takes microseconds */
#define PATIENCE_S 5U /* of the clock, for a half-written line */

static void note(int number)
{
    static const struct itimerval limit = {.it_value = {.tv_sec = WORK_S}};
    if (caught != 0) {
        if ((number == SIGALRM) || (number == SIGPROF)) {
            (void)raise(caught); /* the handler is no longer installed, so this kills the program */
        }
        return;
    }
    caught = number;
    (void)setitimer(ITIMER_PROF, &limit, NULL);
    (void)alarm(PATIENCE_S);
}

void stop_catch(void)
{
    static const int SIGNALS[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE, SIGALRM, SIGTERM,
                                  SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ, SIGPROF};
    struct sigaction action = {.sa_handler = note, .sa_flags = (int)SA_RESETHAND};
    (void)sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
        const bool is_limit = (SIGNALS[i] == SIGALRM) || (SIGNALS[i] == SIGPROF);
        struct sigaction before;
        if ((sigaction(SIGNALS[i], NULL, &before) == 0) &&
            (is_limit || (before.sa_handler == SIG_DFL))) {
            (void)sigaction(SIGNALS[i], &action, NULL);
        }
    }
}

bool stop_requested(sim_error_t *error)
{
    return (caught != 0) && !sim_fail(error, "stopped by signal %d", (int)caught);
}

void stop_die(void)
{
    if (caught != 0) {
        (void)raise(caught);
    }
}
