/* davar-sim - the one-line error message. */
#ifndef SIM_ERROR_H
#define SIM_ERROR_H

#include <stdbool.h>

/* The function that finds the problem fills it once. Callers pass it up unchanged and main prints
 * it. It starts as all zero. */
typedef struct {
    char text[1024];
} sim_error_t;

/* Writes the message (printf rules, no "davar-sim:", no newline) and returns false, so that a
 * function that returns true on success can end with `return sim_fail(...)`. Control characters
 * become '?', so the message stays on one line. */
bool sim_fail(sim_error_t *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
