/* davar-node - counts, one a sample: lines of a file, a FIFO or standard input, or a value file (IIO) read anew each time. */
#ifndef SOURCE_H
#define SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    SOURCE_AGAIN = 0,
    SOURCE_SAMPLE = 1,
    SOURCE_END = 2,
    SOURCE_FAULT = -1
} source_read_t;

typedef struct {
    int descriptor;
    bool is_value; /* value:PATH */
    bool ended;
    bool started;  /* the header is behind us */
    bool too_long; /* what is held goes on a line that found no room */
    size_t held;   /* bytes in text */
    char text[4096];
} source_t;

/* "-", PATH, or value:PATH. False: errno says why. */
bool source_open(source_t *source, const char *where);

/* The next count. FAULT: a line behind the header that is no whole number of 32 bits (one sample is lost), or a value that
 * cannot be read. */
source_read_t source_read(source_t *source, int32_t *count);

void source_close(source_t *source);

#endif
