/* davar for Linux - links of both kinds: opening, loss, reopening, counters. */
#include "link.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

uint64_t link_now_ms(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000U + (uint64_t)now.tv_nsec / 1000000U;
}

uint8_t davar_link_session(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_REALTIME, &now);
    const uint64_t microseconds = (uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_nsec / 1000U;
    return (uint8_t)(1U + microseconds % 255U);
}

void link_count(davar_link_t *link, davar_health_item_t item, uint32_t by)
{
    const uint32_t room = UINT32_MAX - link->count[item];
    link->count[item] += (by < room) ? by : room;
}

/* A line of SLCAN that lacks only its end is not dropped. The end is written when the link is
 * back. */
void link_give_up(davar_link_t *link)
{
    const size_t end = (link->dialect == NULL) ? 1U : 0U;
    link_count(link, DAVAR_HEALTH_FRAMES_DROPPED, (link->pending > end) ? 1U : 0U);
    link->pending = 0;
}

void link_lost(davar_link_t *link)
{
    (void)close(link->descriptor);
    link->descriptor = -1;
    link->passive = false;
    link->off = false;
    link->recovering = false;
    link_give_up(link);
    link->retry_ms = link_now_ms() + LINK_RETRY_MS;
    link_count(link, DAVAR_HEALTH_LINK_LOST, 1U);
}

typedef struct {
    const char *prefix;
    const link_kind_t *kind;
    const davar_dialect_t *dialect; /* null: davar's own frames */
    uint8_t node;                   /* of channel 0 */
} scheme_t;

static const scheme_t SCHEMES[] = {{"can:", &link_can, NULL, 0U},
                                   {"slcan:", &link_tty, NULL, 0U},
                                   {"mavlink:udp:", &link_udp, &davar_mavlink, 191U},
                                   {"mavlink:serial:", &link_tty, &davar_mavlink, 191U},
                                   {"dronecan:", &link_can, &davar_dronecan, 100U},
                                   {"cyphal:", &link_can, &davar_cyphal, 100U}};

/* Null: none of them, or nothing after the prefix. */
static const scheme_t *scheme_of(const char *where)
{
    for (size_t i = 0; i < sizeof SCHEMES / sizeof SCHEMES[0]; i++) {
        const size_t length = strlen(SCHEMES[i].prefix);
        if ((strncmp(where, SCHEMES[i].prefix, length) == 0) && (where[length] != '\0')) {
            return &SCHEMES[i];
        }
    }
    return NULL;
}

const davar_dialect_t *davar_link_dialect(const char *where, uint8_t channel,
                                          davar_telemetry_address_t *address)
{
    const scheme_t *scheme = scheme_of(where);
    if ((scheme == NULL) || (scheme->dialect == NULL)) {
        return NULL;
    }
    *address = (davar_telemetry_address_t){.channel = channel,
                                           .node = (uint8_t)(scheme->node + channel),
                                           .system = 1U,
                                           .subject = 3700U};
    return scheme->dialect;
}

static bool check(const davar_link_options_t *options, const scheme_t *scheme, char *why,
                  size_t size)
{
    if ((scheme == NULL) || (strlen(options->where) >= LINK_NAME_BYTES)) {
        (void)snprintf(why, size, DAVAR_LINK_FORMS " expected, found '%s'", options->where);
        return false;
    }
    if (options->fd && (scheme->kind == &link_tty)) {
        (void)snprintf(why, size, "%s: a serial line carries no CAN FD frames", options->where);
        return false;
    }
    return true;
}

davar_link_t *davar_link_open(const davar_link_options_t *options, char *why, size_t size)
{
    const scheme_t *scheme = scheme_of(options->where);
    if (!check(options, scheme, why, size)) {
        return NULL;
    }
    const char *name = options->where + strlen(scheme->prefix);
    davar_link_t *link = calloc(1U, sizeof *link);
    if (link == NULL) {
        (void)snprintf(why, size, "%s: %s", options->where, strerror(ENOMEM));
        return NULL;
    }
    link->kind = scheme->kind;
    link->prefix = scheme->prefix;
    link->dialect = scheme->dialect;
    link->options = *options;
    link->options.fd = options->fd || (scheme->dialect == &davar_cyphal);
    link->descriptor = -1;
    link->make_pty = (scheme->kind == &link_tty) && (strcmp(name, "pty") == 0);
    link->may_wait = options->wait && !link->make_pty;
    (void)snprintf(link->name, sizeof link->name, "%s", name);
    if (link->kind->open(link, why, size) || link->may_wait) {
        return link;
    }
    free(link);
    return NULL;
}

const char *davar_link_name(const davar_link_t *link)
{
    return link->name;
}

davar_port_send_t davar_link_send(davar_link_t *link, const davar_packet_t *packet)
{
    const davar_port_send_t answer =
        (link->descriptor < 0) ? DAVAR_PORT_SEND_FAULT : link->kind->send(link, packet);
    if (answer == DAVAR_PORT_SEND_AGAIN) {
        link_count(link, DAVAR_HEALTH_SEND_RETRIES, 1U);
    } else if (answer == DAVAR_PORT_SEND_FAULT) {
        link_count(link, DAVAR_HEALTH_FRAMES_DROPPED, 1U);
    }
    return answer;
}

void davar_link_dropped(davar_link_t *link)
{
    link_count(link, DAVAR_HEALTH_FRAMES_DROPPED, 1U);
}

static void reopen(davar_link_t *link)
{
    char why[256];
    if (link_now_ms() < link->retry_ms) {
        return;
    }
    link->retry_ms = link_now_ms() + LINK_RETRY_MS;
    if (link->kind->open(link, why, sizeof why)) {
        link_count(link, DAVAR_HEALTH_LINK_BACK, 1U);
    }
}

void davar_link_poll(davar_link_t *link)
{
    if (link->descriptor < 0) {
        reopen(link);
    } else {
        link->kind->poll(link);
    }
}

bool davar_link_is_up(const davar_link_t *link)
{
    return (link->descriptor >= 0) && (!link->make_pty || link->peer);
}

void davar_link_wait(davar_link_t *link, uint32_t milliseconds)
{
    /* poll() does not detect a full transmit queue (ENOBUFS): sleep briefly and try again. */
    const struct timespec nap = {.tv_sec = (time_t)(milliseconds / 1000U),
                                 .tv_nsec = (long)(milliseconds % 1000U) * 1000000L};
    (void)nanosleep(&nap, NULL);
    davar_link_poll(link);
}

void davar_link_health(const davar_link_t *link, davar_can_health_t *health)
{
    for (size_t item = DAVAR_HEALTH_FRAMES_DROPPED; item <= (size_t)DAVAR_HEALTH_NOISE_BYTES;
         item++) {
        health->count[item] = link->count[item];
    }
}

void davar_link_close(davar_link_t *link)
{
    if (link == NULL) {
        return;
    }
    if (link->descriptor >= 0) {
        link->kind->drain(link);
        (void)close(link->descriptor);
    }
    free(link);
}
