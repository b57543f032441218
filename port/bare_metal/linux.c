/* davar on a board with Linux - the system provides files, console and exit. There is no timer
 * interrupt and no instruction counter. */
#include "board.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void board_text(const char *text)
{
    (void)board_write(STDOUT_FILENO, text, strlen(text));
}

int board_open(const char *path, bool for_writing)
{
    return open(path, for_writing ? (O_WRONLY | O_CREAT | O_TRUNC) : O_RDONLY, 0666);
}

/* A pipe may transfer fewer bytes than requested. */
size_t board_read(int handle, void *data, size_t bytes)
{
    size_t moved = 0U;
    ssize_t now = 1;
    while ((moved < bytes) && (now > 0)) {
        now = read(handle, (char *)data + moved, bytes - moved);
        moved += (now > 0) ? (size_t)now : 0U;
    }
    return moved;
}

size_t board_write(int handle, const void *data, size_t bytes)
{
    size_t moved = 0U;
    ssize_t now = 1;
    while ((moved < bytes) && (now > 0)) {
        now = write(handle, (const char *)data + moved, bytes - moved);
        moved += (now > 0) ? (size_t)now : 0U;
    }
    return moved;
}

void board_close(int handle)
{
    (void)close(handle);
}

void board_command_line(char *text, size_t bytes)
{
    const int own = board_open("/proc/self/cmdline", false);
    const size_t length = (own < 0) ? 0U : board_read(own, text, bytes - 1U);
    for (size_t i = 0U; (i + 1U) < length; i++) {
        text[i] = (text[i] == '\0') ? ' ' : text[i];
    }
    text[length] = '\0';
    board_close(own);
}

_Noreturn void board_exit(int status)
{
    exit(status);
}
