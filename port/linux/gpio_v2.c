/* davar for Linux - gpio through libgpiod 2.x, which reports the kernel's sequence number of each
 * edge. Compiled against 2.1.3 but never run, because Debian 12 has only 1.6.3. */
#include "gpio.h"

#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHIP_BYTES 128U
#define PATH_BYTES (CHIP_BYTES + 16U)
#define CONSUMER "davar-node"

struct gpio_edges {
    struct gpiod_line_request *request;
    struct gpiod_edge_event_buffer *buffer;
    unsigned long last; /* sequence number; 0: none yet */
};

struct gpio_output {
    struct gpiod_line_request *request;
    unsigned line;
};

/* Opens a chip by path, name or number. */
static struct gpiod_chip *open_chip(const char *name)
{
    char path[PATH_BYTES];
    const bool number = (strspn(name, "0123456789") == strlen(name));
    (void)snprintf(path, sizeof path, "%s%s",
                   (name[0] == '/') ? "" : (number ? "/dev/gpiochip" : "/dev/"), name);
    return gpiod_chip_open(path);
}

static struct gpiod_line_request *request_line(struct gpiod_chip *chip, unsigned line, bool output)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_line_config *lines = gpiod_line_config_new();
    struct gpiod_request_config *config = gpiod_request_config_new();
    struct gpiod_line_request *request = NULL;
    if ((settings != NULL) && (lines != NULL) && (config != NULL)) {
        (void)gpiod_line_settings_set_direction(settings, output ? GPIOD_LINE_DIRECTION_OUTPUT
                                                                 : GPIOD_LINE_DIRECTION_INPUT);
        (void)gpiod_line_settings_set_edge_detection(settings, output ? GPIOD_LINE_EDGE_NONE
                                                                      : GPIOD_LINE_EDGE_RISING);
        (void)gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE);
        gpiod_request_config_set_consumer(config, CONSUMER);
        if (gpiod_line_config_add_line_settings(lines, &line, 1, settings) == 0) {
            request = gpiod_chip_request_lines(chip, config, lines);
        }
    }
    const int cause = errno;
    gpiod_request_config_free(config);
    gpiod_line_config_free(lines);
    gpiod_line_settings_free(settings);
    errno = cause;
    return request;
}

static struct gpiod_line_request *request_where(const char *where, bool output, unsigned *line,
                                                char *why, size_t size)
{
    char name[CHIP_BYTES];
    if (!gpio_split(where, name, sizeof name, line)) {
        (void)snprintf(why, size, "CHIP:LINE expected, found '%s'", where);
        return NULL;
    }
    struct gpiod_chip *chip = open_chip(name);
    if (chip == NULL) {
        (void)snprintf(why, size, "%s: no gpio chip '%s': %s", where, name, strerror(errno));
        return NULL;
    }
    struct gpiod_line_request *request = request_line(chip, *line, output);
    if (request == NULL) {
        (void)snprintf(why, size, "%s: %s", where,
                       (errno == EBUSY) ? "busy: another program holds it" : strerror(errno));
    }
    gpiod_chip_close(chip);
    return request;
}

gpio_edges_t *gpio_edges_open(const char *where, uint64_t period_ns, char *why, size_t size)
{
    unsigned line = 0;
    (void)period_ns; /* the kernel counts lost edges */
    struct gpiod_line_request *request = request_where(where, false, &line, why, size);
    if (request == NULL) {
        return NULL;
    }
    gpio_edges_t *edges = calloc(1U, sizeof *edges);
    struct gpiod_edge_event_buffer *buffer = gpiod_edge_event_buffer_new(1);
    if ((edges == NULL) || (buffer == NULL)) {
        (void)snprintf(why, size, "%s: out of memory", where);
        gpiod_edge_event_buffer_free(buffer);
        gpiod_line_request_release(request);
        free(edges);
        return NULL;
    }
    *edges = (gpio_edges_t){.request = request, .buffer = buffer};
    return edges;
}

int gpio_edges_descriptor(const gpio_edges_t *edges)
{
    return gpiod_line_request_get_fd(edges->request);
}

gpio_read_t gpio_edges_read(gpio_edges_t *edges, uint32_t *lost)
{
    const int waits = gpiod_line_request_wait_edge_events(edges->request, 0);
    if (waits == 0) {
        return GPIO_NO_EDGE;
    }
    if ((waits < 0) ||
        (gpiod_line_request_read_edge_events(edges->request, edges->buffer, 1) != 1)) {
        return GPIO_FAULT;
    }
    struct gpiod_edge_event *event = gpiod_edge_event_buffer_get_event(edges->buffer, 0);
    const unsigned long sequence = gpiod_edge_event_get_line_seqno(event);
    *lost = (uint32_t)(sequence - edges->last - 1U); /* the first edge has number 1 */
    edges->last = sequence;
    return GPIO_EDGE;
}

void gpio_edges_close(gpio_edges_t *edges)
{
    if (edges != NULL) {
        gpiod_edge_event_buffer_free(edges->buffer);
        gpiod_line_request_release(edges->request);
        free(edges);
    }
}

gpio_output_t *gpio_output_open(const char *where, char *why, size_t size)
{
    unsigned line = 0;
    struct gpiod_line_request *request = request_where(where, true, &line, why, size);
    gpio_output_t *output = (request != NULL) ? calloc(1U, sizeof *output) : NULL;
    if (output != NULL) {
        *output = (gpio_output_t){.request = request, .line = line};
    } else if (request != NULL) {
        gpiod_line_request_release(request);
    }
    return output;
}

bool gpio_output_set(gpio_output_t *output, bool high)
{
    return gpiod_line_request_set_value(output->request, output->line,
                                        high ? GPIOD_LINE_VALUE_ACTIVE
                                             : GPIOD_LINE_VALUE_INACTIVE) == 0;
}

void gpio_output_close(gpio_output_t *output)
{
    if (output != NULL) {
        gpiod_line_request_release(output->request);
        free(output);
    }
}
