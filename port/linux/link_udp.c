/* davar for Linux - UDP. If the peer's computer refuses packets, they are counted, and sending
 * continues. */
#include "link.h"

#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACK_MS 1000U /* so long without a refused packet, and the peer is back */

/* Splits HOST:PORT at its last colon. An IPv6 address may stand in brackets. */
static bool split(const char *name, char host[LINK_NAME_BYTES], const char **port)
{
    const char *colon = strrchr(name, ':');
    if ((colon == NULL) || (colon == name) || (colon[1] == '\0')) {
        return false;
    }
    const bool bracketed = (*name == '[') && (colon[-1] == ']');
    const size_t length = (size_t)(colon - name) - (bracketed ? 2U : 0U);
    memcpy(host, bracketed ? name + 1 : name, length);
    host[length] = '\0';
    *port = colon + 1;
    return true;
}

static int connect_to(const struct sockaddr *address, socklen_t bytes)
{
    const int descriptor = socket(address->sa_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if ((descriptor >= 0) && (connect(descriptor, address, bytes) != 0)) {
        const int cause = errno;
        (void)close(descriptor);
        errno = cause;
        return -1;
    }
    return descriptor;
}

/* Connects to the first address that accepts it, or else keeps the first one for later. */
static void try_family(davar_link_t *link, const struct addrinfo *found, bool ipv4)
{
    for (const struct addrinfo *one = found; (one != NULL) && (link->descriptor < 0);
         one = one->ai_next) {
        if ((one->ai_family == AF_INET) != ipv4) {
            continue;
        }
        link->descriptor = connect_to(one->ai_addr, one->ai_addrlen);
        if ((link->descriptor >= 0) || (link->address_bytes == 0U)) {
            memcpy(&link->address, one->ai_addr, one->ai_addrlen);
            link->address_bytes = one->ai_addrlen;
        }
    }
}

/* IPv4 first, because ground stations listen there. A name server may take seconds, so this runs
 * only before the first packet, and a host that is not known then is an error. */
static bool resolve(davar_link_t *link, char *why, size_t size)
{
    const struct addrinfo wanted = {.ai_socktype = SOCK_DGRAM, .ai_flags = AI_NUMERICSERV};
    struct addrinfo *found = NULL;
    char host[LINK_NAME_BYTES];
    const char *port = NULL;
    if (!split(link->name, host, &port)) {
        (void)snprintf(why, size, "%s%s: HOST:PORT expected", link->prefix, link->name);
        return false;
    }
    const int fault = getaddrinfo(host, port, &wanted, &found);
    if (fault != 0) {
        (void)snprintf(why, size, "%s%s: %s", link->prefix, link->name, gai_strerror(fault));
        return false;
    }
    try_family(link, found, true);
    try_family(link, found, false);
    const int cause = errno;
    freeaddrinfo(found);
    errno = cause;
    return true;
}

static bool open_udp(davar_link_t *link, char *why, size_t size)
{
    if (link->address_bytes > 0U) {
        link->descriptor = connect_to((const struct sockaddr *)&link->address, link->address_bytes);
    } else if (!resolve(link, why, size)) {
        link->may_wait = false;
        return false;
    }
    if (link->descriptor < 0) {
        (void)snprintf(why, size, "%s%s: %s", link->prefix, link->name, strerror(errno));
        return false;
    }
    link->peer = true;
    link->retry_ms = 0U;
    return true;
}

/* A packet that was sent before has been refused. */
static void note_refused(davar_link_t *link)
{
    link_count(link, DAVAR_HEALTH_FRAMES_DROPPED, 1U);
    link_count(link, DAVAR_HEALTH_LINK_LOST, link->peer ? 1U : 0U);
    link->peer = false;
    link->retry_ms = 0U;
}

/* What the peer sends is not used. */
static void poll_udp(davar_link_t *link)
{
    char ignored[1];
    ssize_t got = 0;
    do {
        got = recv(link->descriptor, ignored, sizeof ignored, 0);
        if ((got < 0) && (errno == ECONNREFUSED)) {
            note_refused(link);
        }
    } while ((got >= 0) || (errno == ECONNREFUSED));
}

static void watch_peer(davar_link_t *link)
{
    const uint64_t now = link_now_ms();
    if (link->peer) {
        return;
    }
    if (link->retry_ms == 0U) {
        link->retry_ms = now;
    } else if (now - link->retry_ms >= BACK_MS) {
        link->peer = true;
        link_count(link, DAVAR_HEALTH_LINK_BACK, 1U);
    }
}

static davar_port_send_t send_udp(davar_link_t *link, const davar_packet_t *packet)
{
    poll_udp(link);
    watch_peer(link);
    if (send(link->descriptor, packet->data, packet->length, 0) >= 0) {
        return DAVAR_PORT_SEND_DONE;
    }
    if (errno == ECONNREFUSED) {
        note_refused(link);
        return DAVAR_PORT_SEND_AGAIN;
    }
    if ((errno == EAGAIN) || (errno == ENOBUFS) || (errno == EINTR)) {
        return DAVAR_PORT_SEND_AGAIN;
    }
    link_lost(link); /* no route: reopened later */
    return DAVAR_PORT_SEND_FAULT;
}

static void drain_udp(davar_link_t *link)
{
    (void)link; /* a packet has left, or never will */
}

const link_kind_t link_udp = {open_udp, send_udp, poll_udp, drain_udp};
