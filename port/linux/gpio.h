/* davar for Linux - gpio lines: data-ready edges in, an alarm out. gpio_v1.c is for libgpiod 1.x,
 * gpio_v2.c for 2.x. CMake selects one by the version that pkg-config reports. */
#ifndef LINUX_GPIO_H
#define LINUX_GPIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct gpio_edges gpio_edges_t;
typedef struct gpio_output gpio_output_t;

typedef enum { GPIO_NO_EDGE = 0, GPIO_EDGE, GPIO_FAULT = -1 } gpio_read_t;

/* Splits "CHIP:LINE": chip by name, number or path, line by number. False: the text has another
 * form. */
bool gpio_split(const char *text, char *chip, size_t size, unsigned *line);

/* Requests the rising edges of a line. period_ns: nominal time between edges. Null: `why` has the
 * cause (no such chip, no such line, busy). */
gpio_edges_t *gpio_edges_open(const char *where, uint64_t period_ns, char *why, size_t size);

/* For poll(): readable if an edge is waiting. */
int gpio_edges_descriptor(const gpio_edges_t *edges);

/* Reads one edge, if one is waiting. *lost is the number of lost edges before it. libgpiod 2 uses
 * the kernel's sequence number. libgpiod 1 has no such number, so the loss is derived from the time
 * stamps and the nominal period. */
gpio_read_t gpio_edges_read(gpio_edges_t *edges, uint32_t *lost);

void gpio_edges_close(gpio_edges_t *edges);

/* Requests a line as output, initially low. */
gpio_output_t *gpio_output_open(const char *where, char *why, size_t size);
bool gpio_output_set(gpio_output_t *output, bool high);
void gpio_output_close(gpio_output_t *output);

#endif
