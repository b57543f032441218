/* davar-sim - the one line that says what went wrong. */
#ifndef SIM_ERROR_H
#define SIM_ERROR_H

#include <stdbool.h>

/* Filled once, by whoever meets the problem; passed up unchanged; printed by main. Starts as all zero. */
typedef struct {
    char text[1024];
} sim_error_t;

/* Writes the message (printf rules, no "davar-sim:", no newline) and returns false, so that `return sim_fail(...)` ends
 * a function that answers true for success. Control characters become '?': the message stays one line. */
bool sim_fail(sim_error_t *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
