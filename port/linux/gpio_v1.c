/* davar for Linux - gpio through libgpiod 1.x (the kernel tests run it with 1.6.3). */
#include "gpio.h"

#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHIP_BYTES 128U
#define CONSUMER "davar-node"

struct gpio_edges {
    struct gpiod_chip *chip;
    struct gpiod_line *line;
    uint64_t period_ns;
    uint64_t last_ns; /* 0: none yet */
};

struct gpio_output {
    struct gpiod_chip *chip;
    struct gpiod_line *line;
};

static struct gpiod_line *get_line(const char *where, struct gpiod_chip **chip, char *why,
                                   size_t size)
{
    char name[CHIP_BYTES];
    unsigned offset = 0;
    if (!gpio_split(where, name, sizeof name, &offset)) {
        (void)snprintf(why, size, "CHIP:LINE expected, found '%s'", where);
        return NULL;
    }
    *chip = gpiod_chip_open_lookup(name);
    if (*chip == NULL) {
        (void)snprintf(why, size, "%s: no gpio chip '%s': %s", where, name, strerror(errno));
        return NULL;
    }
    struct gpiod_line *line = gpiod_chip_get_line(*chip, offset);
    if (line == NULL) {
        (void)snprintf(why, size, "%s: the chip has %u lines", where, gpiod_chip_num_lines(*chip));
        gpiod_chip_close(*chip);
    }
    return line;
}

static void refuse(const char *where, struct gpiod_chip *chip, char *why, size_t size)
{
    (void)snprintf(why, size, "%s: %s", where,
                   (errno == EBUSY) ? "busy: another program holds it" : strerror(errno));
    gpiod_chip_close(chip);
}

gpio_edges_t *gpio_edges_open(const char *where, uint64_t period_ns, char *why, size_t size)
{
    struct gpiod_chip *chip = NULL;
    struct gpiod_line *line = get_line(where, &chip, why, size);
    if (line == NULL) {
        return NULL;
    }
    gpio_edges_t *edges = calloc(1U, sizeof *edges);
    if ((edges == NULL) || (gpiod_line_request_rising_edge_events(line, CONSUMER) != 0)) {
        refuse(where, chip, why, size);
        free(edges);
        return NULL;
    }
    *edges = (gpio_edges_t){.chip = chip, .line = line, .period_ns = period_ns};
    return edges;
}

int gpio_edges_descriptor(const gpio_edges_t *edges)
{
    return gpiod_line_event_get_fd(edges->line);
}

/* The number of complete periods without an edge. */
static uint32_t lost_since(const gpio_edges_t *edges, uint64_t now_ns)
{
    const uint64_t passed = now_ns - edges->last_ns;
    const bool known =
        (edges->last_ns > 0U) && (edges->period_ns > 0U) && (now_ns > edges->last_ns);
    const uint64_t periods = known ? (passed + edges->period_ns / 2U) / edges->period_ns : 1U;
    return (periods > 1U) ? (uint32_t)(periods - 1U) : 0U;
}

gpio_read_t gpio_edges_read(gpio_edges_t *edges, uint32_t *lost)
{
    struct pollfd one = {.fd = gpio_edges_descriptor(edges), .events = POLLIN};
    struct gpiod_line_event event;
    if (poll(&one, 1, 0) == 0) {
        return GPIO_NO_EDGE;
    }
    if (gpiod_line_event_read(edges->line, &event) != 0) {
        return GPIO_FAULT;
    }
    const uint64_t now_ns = (uint64_t)event.ts.tv_sec * 1000000000U + (uint64_t)event.ts.tv_nsec;
    *lost = lost_since(edges, now_ns);
    edges->last_ns = now_ns;
    return GPIO_EDGE;
}

void gpio_edges_close(gpio_edges_t *edges)
{
    if (edges != NULL) {
        gpiod_chip_close(edges->chip);
        free(edges);
    }
}

gpio_output_t *gpio_output_open(const char *where, char *why, size_t size)
{
    struct gpiod_chip *chip = NULL;
    struct gpiod_line *line = get_line(where, &chip, why, size);
    if (line == NULL) {
        return NULL;
    }
    gpio_output_t *output = calloc(1U, sizeof *output);
    if ((output == NULL) || (gpiod_line_request_output(line, CONSUMER, 0) != 0)) {
        refuse(where, chip, why, size);
        free(output);
        return NULL;
    }
    *output = (gpio_output_t){.chip = chip, .line = line};
    return output;
}

bool gpio_output_set(gpio_output_t *output, bool high)
{
    return gpiod_line_set_value(output->line, high ? 1 : 0) == 0;
}

void gpio_output_close(gpio_output_t *output)
{
    if (output != NULL) {
        gpiod_chip_close(output->chip);
        free(output);
    }
}
