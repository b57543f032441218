/* davar-sim - signals that end the program. The program finishes the line it is writing, cleans up
 * and dies of the signal. It dies without cleaning up if the same signal arrives again, after 1 s
 * of further work, or if a reader accepts nothing for 5 s. */
#ifndef STOP_H
#define STOP_H

#include "common/sim_error.h"

/* Installs the handlers. Ignored signals stay ignored, except SIGALRM and SIGPROF, which end a
 * program that hangs. */
void stop_catch(void);

/* True if a signal has arrived; the error then gives its number. */
bool stop_requested(sim_error_t *error);

/* Dies of the signal that has arrived. Returns if there was no signal. */
void stop_die(void);

#endif
