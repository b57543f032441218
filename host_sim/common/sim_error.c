/* davar-sim - error text. */
#include "common/sim_error.h"

#include <stdarg.h>
#include <stdio.h>

static bool is_control(char c)
{
    const unsigned char byte = (unsigned char)c;
    return (byte < 0x20U) || (byte == 0x7FU);
}

bool sim_fail(sim_error_t *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    /* The analyser does not recognise va_start.
     * NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized) */
    (void)vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    for (char *c = error->text; *c != '\0'; c++) {
        if (is_control(*c)) {
            *c = '?';
        }
    }
    return false;
}
