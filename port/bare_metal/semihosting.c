/* davar on a bare board - files, console and exit through ARM semihosting, which RISC-V has
 * adopted. */
#include "semihosting.h"
#include "board.h"

#include <string.h>

enum {
    SYS_OPEN = 0x01,
    SYS_CLOSE = 0x02,
    SYS_WRITE0 = 0x04,
    SYS_WRITE = 0x05,
    SYS_READ = 0x06,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20
};

#define MODE_READ 1U  /* "rb" */
#define MODE_WRITE 5U /* "wb" */
#define APPLICATION_EXIT 0x20026U

void board_text(const char *text)
{
    (void)semihosting_call(SYS_WRITE0, text);
}

int board_open(const char *path, bool for_writing)
{
    const uintptr_t block[3] = {(uintptr_t)path, for_writing ? MODE_WRITE : MODE_READ,
                                strlen(path)};
    return (int)semihosting_call(SYS_OPEN, block);
}

/* Both calls return the bytes that were NOT moved. */
size_t board_read(int handle, void *data, size_t bytes)
{
    const uintptr_t block[3] = {(uintptr_t)handle, (uintptr_t)data, bytes};
    return bytes - (size_t)semihosting_call(SYS_READ, block);
}

size_t board_write(int handle, const void *data, size_t bytes)
{
    const uintptr_t block[3] = {(uintptr_t)handle, (uintptr_t)data, bytes};
    return bytes - (size_t)semihosting_call(SYS_WRITE, block);
}

void board_close(int handle)
{
    const uintptr_t block[1] = {(uintptr_t)handle};
    (void)semihosting_call(SYS_CLOSE, block);
}

void board_command_line(char *text, size_t bytes)
{
    uintptr_t block[2] = {(uintptr_t)text, bytes};
    text[0] = '\0';
    (void)semihosting_call(SYS_GET_CMDLINE, block);
}

_Noreturn void board_exit(int status)
{
    const uintptr_t block[2] = {APPLICATION_EXIT, (uintptr_t)status};
    for (;;) {
        (void)semihosting_call(SYS_EXIT_EXTENDED, block);
    }
}
