/* davar-node - one count per sample: lines of a file, a FIFO or standard input, or a value file
 * (IIO) that is read again for each sample. */
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
    bool started;  /* the header has been read */
    bool too_long; /* the buffer continues a line that was too long */
    size_t held;   /* bytes in text */
    char text[4096];
} source_t;

/* Opens "-", PATH, or value:PATH. False: see errno. */
bool source_open(source_t *source, const char *where);

/* Reads the next count. FAULT: a line after the header is not a 32-bit whole number (one sample is
 * lost), or a value cannot be read. */
source_read_t source_read(source_t *source, int32_t *count);

void source_close(source_t *source);

#endif
