/* davar-sim - reads the bytes of a file. The first two bytes identify gzip, not the name. */
#include "recording/bytes_in.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define BUFFER_BYTES ((size_t)131072U)
#define GZIP_ONLY (15 + 16) /* window bits, in the encoding of zlib */
#define GZIP_FIRST 0x1FU
#define GZIP_SECOND 0x8BU

/* A recording shrinks to a fifth or a tenth, and to a fiftieth if the sensor is stuck. A larger
 * factor is rejected: a few bytes could fill the disk. */
#define GROWTH_MAX 100U
#define GROWTH_FREE ((uint64_t)64U * 1024U * 1024U)

static int open_descriptor(const char *name)
{
    return (strcmp(name, "-") == 0) ? dup(STDIN_FILENO) : open(name, O_RDONLY | O_CLOEXEC);
}

static bool is_standard_output(const struct stat *status)
{
    struct stat output;
    return S_ISREG(status->st_mode) && (fstat(STDOUT_FILENO, &output) == 0) &&
           (output.st_dev == status->st_dev) && (output.st_ino == status->st_ino);
}

/* /dev/zero has no end, and reading other devices may have side effects. */
static bool is_device(const struct stat *status, int descriptor)
{
    return (S_ISCHR(status->st_mode) || S_ISBLK(status->st_mode)) && !isatty(descriptor);
}

static bool inspect(bytes_in_t *in, const char *name, sim_error_t *error)
{
    struct stat status;
    if (fstat(in->descriptor, &status) != 0) {
        return sim_fail(error, "%s: %s", name, strerror(errno));
    }
    if (S_ISDIR(status.st_mode)) {
        return sim_fail(error, "%s: is a directory, not a recording", name);
    }
    if (is_device(&status, in->descriptor)) {
        return sim_fail(error, "%s: is a device; use a file, a pipe or a terminal", name);
    }
    if (is_standard_output(&status)) {
        return sim_fail(error, "%s: is also standard output: results would be read as data", name);
    }
    in->file_bytes = S_ISREG(status.st_mode) ? (uint64_t)status.st_size : 0U;
    in->at_end =
        /* otherwise a file of /proc would block */
        S_ISREG(status.st_mode) && (status.st_size == 0);
    return true;
}

bool bytes_in_open(bytes_in_t *in, const char *name, sim_error_t *error)
{
    *in = (bytes_in_t){.descriptor = open_descriptor(name)};
    if (in->descriptor < 0) {
        return sim_fail(error, "%s: %s", name, strerror(errno));
    }
    if (!inspect(in, name, error)) {
        return false;
    }
    in->buffer = malloc(BUFFER_BYTES);
    in->unpacking = (in->buffer != NULL) && (inflateInit2(&in->stream, GZIP_ONLY) == Z_OK);
    return in->unpacking || sim_fail(error, "%s: out of memory", name);
}

/* Appends data to the unread bytes. */
static const char *fill(bytes_in_t *in)
{
    if (in->left > 0U) {
        memmove(in->buffer, in->next, in->left);
    }
    in->next = in->buffer;
    ssize_t got = -1;
    do {
        got = read(in->descriptor, in->buffer + in->left, BUFFER_BYTES - in->left);
    } while ((got < 0) && (errno == EINTR));
    if (got < 0) {
        return strerror(errno);
    }
    in->left += (size_t)got;
    in->at_end = (got == 0);
    return NULL;
}

static void use(bytes_in_t *in, size_t count)
{
    in->next += count;
    in->left -= count;
    in->taken += count;
}

/* A pipe may deliver the first byte alone. */
static const char *recognise(bytes_in_t *in)
{
    while (!in->at_end && (in->left < 2U)) {
        const char *problem = fill(in);
        if (problem != NULL) {
            return problem;
        }
    }
    const bool packed =
        (in->left >= 2U) && (in->next[0] == GZIP_FIRST) && (in->next[1] == GZIP_SECOND);
    in->place = packed ? BYTES_MEMBER : BYTES_PLAIN;
    return NULL;
}

static size_t copy(bytes_in_t *in, void *to, size_t room)
{
    const size_t count = (in->left < room) ? in->left : room;
    memcpy(to, in->next, count);
    use(in, count);
    return count;
}

/* After a member comes another one, or zeros to the end (padding of tapes and blocks), or
 * damage. */
static const char *go_on(bytes_in_t *in)
{
    if (*in->next == 0U) {
        in->place = BYTES_PADDING;
    }
    if (in->place == BYTES_PADDING) {
        while ((in->left > 0U) && (*in->next == 0U)) {
            use(in, 1U);
        }
        return (in->left == 0U) ? NULL : "extra bytes after the zeros that follow the gzip data";
    }
    if ((*in->next != GZIP_FIRST) || (inflateReset(&in->stream) != Z_OK)) {
        return "bytes after the gzip data that are not gzip (damaged or appended)";
    }
    in->place = BYTES_MEMBER;
    return NULL;
}

static const char *corrupt(bytes_in_t *in, int code)
{
    if (code == Z_MEM_ERROR) {
        return "out of memory";
    }
    (void)snprintf(in->why, sizeof in->why, "corrupt gzip data (%s)",
                   (in->stream.msg != NULL) ? in->stream.msg : "it needs a dictionary");
    return in->why;
}

static const char *unpack(bytes_in_t *in, void *to, size_t room, size_t *got)
{
    const size_t offered = in->left;
    in->stream.next_in = (z_const Bytef *)in->next;
    in->stream.avail_in = (uInt)offered;
    in->stream.next_out = to;
    in->stream.avail_out = (uInt)room;
    const int code = inflate(&in->stream, Z_NO_FLUSH);
    use(in, offered - in->stream.avail_in);
    *got = room - in->stream.avail_out;
    if (code == Z_STREAM_END) {
        in->place = BYTES_BETWEEN;
    } else if ((code != Z_OK) && (code != Z_BUF_ERROR)) {
        return corrupt(in, code);
    }
    const uint64_t given = in->given + *got;
    if ((given > GROWTH_FREE) && (given / GROWTH_MAX > in->taken)) {
        return "gzip data that unpacks to more than 64 MiB and 100 times its size is rejected; if "
               "it is a recording, unpack it first";
    }
    return NULL;
}

/* One step: reads the file, unpacks data, or begins the next member. */
static const char *step(bytes_in_t *in, void *to, size_t room, size_t *got)
{
    if (in->left == 0U) {
        return fill(in);
    }
    switch (in->place) {
    case BYTES_MEMBER:
        return unpack(in, to, room, got);
    case BYTES_BETWEEN:
    case BYTES_PADDING:
        return go_on(in);
    case BYTES_PLAIN:
    default:
        *got = copy(in, to, room);
        return NULL;
    }
}

const char *bytes_in_read(bytes_in_t *in, void *to, size_t room, size_t *got)
{
    const uInt most = (room < BUFFER_BYTES) ? (uInt)room : (uInt)BUFFER_BYTES;
    const char *problem = (in->given == 0U) && (in->taken == 0U) ? recognise(in) : NULL;
    *got = 0;
    while ((problem == NULL) && (*got == 0U) && !(in->at_end && (in->left == 0U))) {
        problem = step(in, to, most, got);
    }
    in->given += *got;
    if ((problem == NULL) && (*got == 0U) && (in->place == BYTES_MEMBER)) {
        return "gzip data ends too early (truncated file)";
    }
    return problem;
}

double bytes_in_fraction(const bytes_in_t *in)
{
    if (in->file_bytes == 0U) {
        return -1.0;
    }
    const double fraction = (double)in->taken / (double)in->file_bytes;
    return (fraction < 1.0) ? fraction : 1.0;
}

void bytes_in_close(bytes_in_t *in)
{
    if (in->unpacking) {
        (void)inflateEnd(&in->stream);
    }
    if (in->descriptor >= 0) {
        (void)close(in->descriptor);
    }
    free(in->buffer);
    *in = (bytes_in_t){.descriptor = -1};
}
