/* davar for Linux - built without libgpiod. */
#include "../linux/gpio.h"

#include <stdio.h>

gpio_edges_t *gpio_edges_open(const char *where, uint64_t period_ns, char *why, size_t size)
{
    (void)period_ns;
    (void)snprintf(why, size, "%s: built without libgpiod", where);
    return NULL;
}

int gpio_edges_descriptor(const gpio_edges_t *edges)
{
    (void)edges;
    return -1;
}

gpio_read_t gpio_edges_read(gpio_edges_t *edges, uint32_t *lost)
{
    (void)edges;
    *lost = 0;
    return GPIO_FAULT;
}

void gpio_edges_close(gpio_edges_t *edges)
{
    (void)edges;
}

gpio_output_t *gpio_output_open(const char *where, char *why, size_t size)
{
    (void)snprintf(why, size, "%s: built without libgpiod", where);
    return NULL;
}

bool gpio_output_set(gpio_output_t *output, bool high)
{
    (void)output;
    (void)high;
    return false;
}

void gpio_output_close(gpio_output_t *output)
{
    (void)output;
}
