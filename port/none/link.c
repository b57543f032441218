/* davar - no links, for systems without SocketCAN and termios. */
#include "davar_link.h"

#include <stdio.h>

const davar_dialect_t *davar_link_dialect(const char *where, uint8_t channel,
                                          davar_telemetry_address_t *address)
{
    (void)where;
    (void)channel;
    (void)address;
    return NULL;
}

davar_link_t *davar_link_open(const davar_link_options_t *options, char *why, size_t size)
{
    (void)snprintf(why, size, "%s: output to a CAN bus, a serial line or UDP needs Linux",
                   options->where);
    return NULL;
}

const char *davar_link_name(const davar_link_t *link)
{
    (void)link;
    return "";
}

davar_port_send_t davar_link_send(davar_link_t *link, const davar_packet_t *packet)
{
    (void)link;
    (void)packet;
    return DAVAR_PORT_SEND_FAULT;
}

void davar_link_dropped(davar_link_t *link)
{
    (void)link;
}

void davar_link_poll(davar_link_t *link)
{
    (void)link;
}

bool davar_link_is_up(const davar_link_t *link)
{
    (void)link;
    return false;
}

void davar_link_wait(davar_link_t *link, uint32_t milliseconds)
{
    (void)link;
    (void)milliseconds;
}

void davar_link_health(const davar_link_t *link, davar_can_health_t *health)
{
    (void)link;
    (void)health;
}

uint8_t davar_link_session(void)
{
    return 0U;
}

void davar_link_close(davar_link_t *link)
{
    (void)link;
}
