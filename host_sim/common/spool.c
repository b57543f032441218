/* davar-sim - temporary records. */
#include "common/spool.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BUFFER_DOUBLES 16384U

const char *spool_folder(void)
{
    const char *named = getenv("TMPDIR");
    return ((named != NULL) && (*named != '\0')) ? named : "/tmp";
}

static bool fail_file(sim_error_t *error, const char *doing)
{
    return sim_fail(error, "temporary file in %s (TMPDIR): %s: %s", spool_folder(), doing,
                    strerror(errno));
}

static bool make_unnamed(spool_t *spool, char *path, sim_error_t *error)
{
    spool->descriptor = mkstemp(path);
    if (spool->descriptor < 0) {
        return fail_file(error, "cannot create");
    }
    return (unlink(path) == 0) ? true : fail_file(error, "cannot unlink");
}

/* Signals are blocked while the file has a name; otherwise the file could remain. */
static bool open_unnamed(spool_t *spool, sim_error_t *error)
{
    char path[4096];
    const int length = snprintf(path, sizeof path, "%s/davar-sim-XXXXXX", spool_folder());
    if ((length < 0) || ((size_t)length >= sizeof path)) {
        return sim_fail(error, "temporary file: TMPDIR is too long");
    }
    sigset_t all;
    sigset_t before;
    (void)sigfillset(&all);
    (void)sigprocmask(SIG_SETMASK, &all, &before);
    const bool good = make_unnamed(spool, path, error);
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return good;
}

bool spool_open(spool_t *spool, size_t width, sim_error_t *error)
{
    const size_t capacity = (width < BUFFER_DOUBLES) ? BUFFER_DOUBLES / width : 1U;
    *spool = (spool_t){.descriptor = -1, .width = width, .capacity = capacity};
    spool->buffer = malloc(capacity * width * sizeof(double));
    if (spool->buffer == NULL) {
        return sim_fail(error, "out of memory");
    }
    return open_unnamed(spool, error);
}

static bool write_all(int descriptor, const char *bytes, size_t count, sim_error_t *error)
{
    while (count > 0U) {
        const ssize_t wrote = write(descriptor, bytes, count);
        if ((wrote < 0) && (errno != EINTR)) {
            return fail_file(error, "cannot write");
        }
        const size_t done = (wrote > 0) ? (size_t)wrote : 0U;
        bytes += done;
        count -= done;
    }
    return true;
}

bool spool_flush(spool_t *spool, sim_error_t *error)
{
    const size_t bytes = spool->buffered * spool->width * sizeof(double);
    spool->buffered = 0;
    return write_all(spool->descriptor, (const char *)spool->buffer, bytes, error);
}

bool spool_put(spool_t *spool, const double *record, sim_error_t *error)
{
    double *slot = spool->buffer + spool->buffered * spool->width;
    for (size_t i = 0; i < spool->width; i++) {
        slot[i] = record[i];
    }
    spool->buffered++;
    spool->records++;
    return (spool->buffered < spool->capacity) || spool_flush(spool, error);
}

bool spool_read(const spool_t *spool, uint64_t first, size_t count, double *records,
                sim_error_t *error)
{
    const size_t record_bytes = spool->width * sizeof(double);
    char *bytes = (char *)records;
    size_t left = count * record_bytes;
    off_t offset = (off_t)(first * record_bytes);
    while (left > 0U) {
        const ssize_t got = pread(spool->descriptor, bytes, left, offset);
        if ((got == 0) || ((got < 0) && (errno != EINTR))) {
            errno = (got == 0) ? EIO : errno;
            return fail_file(error, "cannot read");
        }
        const size_t done = (got > 0) ? (size_t)got : 0U;
        bytes += done;
        left -= done;
        offset += (off_t)done;
    }
    return true;
}

void spool_close(spool_t *spool)
{
    if ((spool->buffer != NULL) && (spool->descriptor >= 0)) {
        (void)close(spool->descriptor);
    }
    free(spool->buffer);
    *spool = (spool_t){.descriptor = -1};
}
