/* davar-sim - signals that end the program: it goes on to the end of the line it is writing, cleans up and dies of the signal. It dies
 * without cleaning up when the same signal comes again, after 1 s of further work, or when a reader takes nothing for 5 s. */
#ifndef STOP_H
#define STOP_H

#include "common/sim_error.h"

/* From here on; signals that are ignored stay so, but for SIGALRM and SIGPROF, which end what does not end. */
void stop_catch(void);

/* True once a signal has come, with an error that says so. */
bool stop_asked(sim_error_t *error);

/* Dies of the signal that has come; returns when none has. */
void stop_die(void);

#endif
