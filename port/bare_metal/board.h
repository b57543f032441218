/* davar on a bare board - functions an image needs in addition to the library: console output,
 * files of the host (semihosting), exact instruction counts of the emulator, a timer interrupt, a
 * UART, and exit with a status. cortex_m.c and riscv.c implement the functions of the core. mps2.c,
 * mps3.c, microbit.c and virt.c implement those of the board. linux.c uses a system with files:
 * text, files, the command line, exit. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The start-up code calls it before main: enables the FPU and starts the counter. */
void board_start(void);

/* Instructions executed since `mark`, modulo 2^32 / 16 on ARM (24-bit SysTick: keep one measurement
 * below two million). Exact only under the emulator's -icount shift=8 (ARM) or shift=0 (RISC-V);
 * without it the figure is meaningless. */
uint32_t board_instructions_since(uint32_t mark);
uint32_t board_mark(void);

/* Prints text on the host's console. */
void board_text(const char *text);

/* Files of the host. A negative handle: cannot be opened. read and write return the number of bytes
 * transferred. */
int board_open(const char *path, bool for_writing);
size_t board_read(int handle, void *data, size_t bytes);
size_t board_write(int handle, const void *data, size_t bytes);
void board_close(int handle);

/* The emulator's command line for the image, cut to `bytes`. */
void board_command_line(char *text, size_t bytes);

/* Reads the command line and splits it into words, which point into `text`. Returns their number,
 * at most `most`. The first is the name of the image. */
size_t board_words(char *text, size_t bytes, char *words[], size_t most);

/* Prints "name value" as a line on the host's console. */
void board_figure(const char *name, uint32_t value);

/* A free-running clock, BOARD_CLOCK_PER_US ticks per microsecond, modulo 2^32. */
uint32_t board_clock(void);

/* Starts a timer interrupt that calls board_tick (defined by the image) at this period: 1 .. 600
 * 000 us. Stops the instruction counter. */
void board_tick_every(uint32_t microseconds);
void board_tick(void);

/* Writes one character to the UART's transmitter. False: no room now. */
bool board_serial_put(char character);

/* Ends the emulation with an exit status. */
_Noreturn void board_exit(int status);

#endif
