/* davar on a bare board - what an image needs beside the library: characters out, files of the host (semihosting), exact
 * instruction counts of the emulator, an end with a status. One implementation per architecture. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Called by the start-up code before main: FPU on, counter running. */
void board_start(void);

/* Instructions executed so far, modulo 2^32 / 16 on ARM (24-bit SysTick: keep one bracket below two million). Exact only
 * under the emulator's -icount shift=8 (ARM) or shift=0 (RISC-V); without it the figure means nothing. */
uint32_t board_instructions_since(uint32_t mark);
uint32_t board_mark(void);

/* Text to the host's console. */
void board_text(const char *text);

/* Files of the host. A handle below 0: cannot be opened. read and write return the bytes moved. */
int board_open(const char *path, bool for_writing);
size_t board_read(int handle, void *data, size_t bytes);
size_t board_write(int handle, const void *data, size_t bytes);
void board_close(int handle);

/* The command line that the emulator was given, cut to `bytes`. */
void board_command_line(char *text, size_t bytes);

/* Ends the emulation with an exit status. */
_Noreturn void board_exit(int status);

#endif
