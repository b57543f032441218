/* davar for Linux - gpio lines: data-ready edges in, an alarm out. gpio_v1.c is for libgpiod 1.x, gpio_v2.c for 2.x;
 * CMake takes the one that pkg-config's version asks for. */
#ifndef LINUX_GPIO_H
#define LINUX_GPIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct gpio_edges gpio_edges_t;
typedef struct gpio_output gpio_output_t;

typedef enum { GPIO_NO_EDGE = 0, GPIO_EDGE, GPIO_FAULT = -1 } gpio_read_t;

/* "CHIP:LINE": chip by name, number or path, line by number. False: it is not that. */
bool gpio_split(const char *text, char *chip, size_t size, unsigned *line);

/* Requests the rising edges of a line. period_ns: nominal time between edges. Null: `why` says what is wrong (no such
 * chip, no such line, busy). */
gpio_edges_t *gpio_edges_open(const char *where, uint64_t period_ns, char *why, size_t size);

/* For poll(): readable when an edge waits. */
int gpio_edges_descriptor(const gpio_edges_t *edges);

/* Takes one edge, if one waits; *lost is the number of edges before it that nobody could read. libgpiod 2 has the
 * kernel's sequence number; libgpiod 1 has none, so the time stamps of the edges and their nominal period count. */
gpio_read_t gpio_edges_read(gpio_edges_t *edges, uint32_t *lost);

void gpio_edges_close(gpio_edges_t *edges);

/* Requests a line as output, low. */
gpio_output_t *gpio_output_open(const char *where, char *why, size_t size);
bool gpio_output_set(gpio_output_t *output, bool high);
void gpio_output_close(gpio_output_t *output);

#endif
