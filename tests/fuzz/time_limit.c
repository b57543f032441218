/* davar tests - a time limit for each input of every fuzz target, however it is run: an input that
 * does not end is a fault. A -timeout on the command line comes later and overrides it. The limit
 * is generous: an input takes milliseconds, and the machine may be busy. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static char limit[] = "-timeout=120"; /* seconds */
    const size_t count = (size_t)*argc;
    char **const more = calloc(count + 2U, sizeof *more);
    if (more == NULL) {
        return 0;
    }
    more[0] = (*argv)[0];
    more[1] = limit;
    memcpy(&more[2], &(*argv)[1], (count - 1U) * sizeof *more);
    *argv = more;
    (*argc)++;
    return 0;
}
