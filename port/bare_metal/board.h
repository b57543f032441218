/* davar on a bare board - what an image needs beside the library: characters out, files of the host (semihosting), exact
 * instruction counts of the emulator, a timer interrupt, a UART, an end with a status. cortex_m.c and riscv.c implement what
 * belongs to the core, mps2.c, mps3.c, microbit.c and virt.c what belongs to the board. linux.c has what a system with files
 * gives: text, files, the command line, the end. */
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

/* The same, split into its words, which point into `text`. Returns how many there are, `most` at the most; the first is
 * the name of the image. */
size_t board_words(char *text, size_t bytes, char *words[], size_t most);

/* "name value" as a line on the host's console. */
void board_figure(const char *name, uint32_t value);

/* A free-running clock, BOARD_CLOCK_PER_US ticks a microsecond, modulo 2^32. */
uint32_t board_clock(void);

/* From now on the timer interrupt calls board_tick (the image's own) so often: 1 .. 600 000 us. Ends the counting of
 * instructions. */
void board_tick_every(uint32_t microseconds);
void board_tick(void);

/* Puts one character into the UART's transmitter. False: no room now. */
bool board_serial_put(char character);

/* Ends the emulation with an exit status. */
_Noreturn void board_exit(int status);

#endif
