/* davar for Linux - SLCAN text or MAVLink on a tty, or on a pty that we create. With SLCAN, we act
 * as the adapter; slcand or python-can is the host. */
#include "link.h"

#include "davar/slcan.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define DRAIN_MS 15000U /* without progress: a busy computer runs the peer late */
#define DRAIN_STEP_MS 5
#define DRAIN_QUIET_STEPS 10U
#define LINE_MAX_SLCAN 32U

static const struct {
    uint32_t baud;
    speed_t code;
} speeds[] = {{9600, B9600},       {19200, B19200},    {38400, B38400},   {57600, B57600},
              {115200, B115200},   {230400, B230400},  {460800, B460800}, {921600, B921600},
              {1000000, B1000000}, {3000000, B3000000}};

static bool set_speed(struct termios *line, uint32_t baud)
{
    for (size_t i = 0; i < sizeof speeds / sizeof speeds[0]; i++) {
        if (speeds[i].baud == baud) {
            return (cfsetispeed(line, speeds[i].code) == 0) &&
                   (cfsetospeed(line, speeds[i].code) == 0);
        }
    }
    errno = EINVAL;
    return baud == 0U;
}

/* Raw: eight bits, no echo, no translation. */
static bool make_raw(int descriptor, uint32_t baud)
{
    struct termios line;
    if (tcgetattr(descriptor, &line) != 0) {
        return false;
    }
    line.c_iflag &=
        ~(tcflag_t)(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL | IXON | IXOFF);
    line.c_oflag &= ~(tcflag_t)OPOST;
    line.c_lflag &= ~(tcflag_t)(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
    line.c_cflag &= ~(tcflag_t)(CSIZE | PARENB);
    line.c_cflag |= (tcflag_t)(CS8 | CLOCAL | CREAD);
    return set_speed(&line, baud) && (tcsetattr(descriptor, TCSANOW, &line) == 0);
}

/* SLCAN: ends an incomplete line of a lost frame. A receiver of MAVLink finds the next packet. */
static void begin_text(davar_link_t *link)
{
    link->text[0] = '\r';
    link->pending = (link->dialect == NULL) ? 1U : 0U;
}

/* After the other side was opened and closed once, the kernel reports "hung up" until a peer opens
 * it. */
static bool open_pty(davar_link_t *link)
{
    link->descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if ((link->descriptor < 0) || (grantpt(link->descriptor) != 0) ||
        (unlockpt(link->descriptor) != 0) || (fcntl(link->descriptor, F_SETFL, O_NONBLOCK) != 0)) {
        return false;
    }
    (void)snprintf(link->name, sizeof link->name, "%s", ptsname(link->descriptor));
    const int other = open(link->name, O_RDWR | O_NOCTTY | O_CLOEXEC);
    return (other >= 0) && make_raw(other, 0U) && (close(other) == 0);
}

static bool open_file(davar_link_t *link)
{
    link->descriptor = open(link->name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    return (link->descriptor >= 0) && make_raw(link->descriptor, link->options.baud);
}

static bool open_tty(davar_link_t *link, char *why, size_t size)
{
    if (!(link->make_pty ? open_pty(link) : open_file(link))) {
        (void)snprintf(why, size, "%s%s: %s", link->prefix, link->name, strerror(errno));
        (void)((link->descriptor >= 0) && (close(link->descriptor) == 0));
        link->descriptor = -1;
        return false;
    }
    begin_text(link);
    return true;
}

/* Writes pending characters. False: the tty accepts no more now. */
static bool push_pending(davar_link_t *link)
{
    while (link->pending > 0U) {
        const ssize_t done = write(link->descriptor, link->text, link->pending);
        if (done <= 0) {
            if ((done < 0) && (errno != EAGAIN) && (errno != EINTR)) {
                link_lost(link);
            }
            return false;
        }
        link->pending -= (size_t)done;
        memmove(link->text, link->text + done, link->pending);
    }
    return true;
}

static bool hung_up(const davar_link_t *link)
{
    struct pollfd one = {.fd = link->descriptor, .events = POLLOUT};
    return (poll(&one, 1, 0) > 0) && ((one.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0);
}

/* The pty stays open while peers connect and disconnect. */
static void watch_peer(davar_link_t *link)
{
    const bool there = !hung_up(link);
    if (link->peer && !there) {
        (void)tcflush(link->descriptor, TCIOFLUSH);
        link_give_up(link);
        begin_text(link);
        link_count(link, DAVAR_HEALTH_LINK_LOST, 1U);
    } else if (!link->peer && there && (link->count[DAVAR_HEALTH_LINK_LOST] > 0U)) {
        link_count(link, DAVAR_HEALTH_LINK_BACK, 1U);
    }
    link->peer = there;
}

static size_t encode(const davar_link_t *link, const davar_packet_t *packet, char *text)
{
    if (link->dialect != NULL) {
        memcpy(text, packet->data, packet->length);
        return packet->length;
    }
    davar_frame_t frame = {.identifier = (uint16_t)packet->identifier, .length = packet->length};
    memcpy(frame.data, packet->data, packet->length);
    return davar_slcan_encode(&frame, text);
}

static davar_port_send_t send_tty(davar_link_t *link, const davar_packet_t *packet)
{
    if (link->make_pty) {
        watch_peer(link);
        if (!link->peer) {
            return (link->count[DAVAR_HEALTH_LINK_LOST] > 0U) ? DAVAR_PORT_SEND_FAULT
                                                              : DAVAR_PORT_SEND_AGAIN;
        }
    }
    if (!push_pending(link)) {
        return (link->descriptor < 0) ? DAVAR_PORT_SEND_FAULT : DAVAR_PORT_SEND_AGAIN;
    }
    link->pending = encode(link, packet, link->text);
    (void)push_pending(link);
    return DAVAR_PORT_SEND_DONE; /* otherwise the frame is dropped and counted */
}

/* Commands of an SLCAN host (O, C, S6, V, t..., and their answers) do not count as noise. */
static void receive(davar_link_t *link, unsigned char byte)
{
    link->odd = link->odd || ((byte != '\r') && (byte != '\n') && !isalnum(byte)) ||
                (link->received > LINE_MAX_SLCAN);
    if (byte != '\r') {
        link->received++;
        return;
    }
    link_count(link, DAVAR_HEALTH_NOISE_BYTES, link->odd ? (uint32_t)link->received : 0U);
    link->received = 0;
    link->odd = false;
}

static void poll_tty(davar_link_t *link)
{
    unsigned char bytes[256];
    ssize_t got = 0;
    if (link->make_pty) {
        watch_peer(link);
    }
    while ((got = read(link->descriptor, bytes, sizeof bytes)) > 0) {
        for (ssize_t i = 0; (i < got) && (link->dialect == NULL); i++) {
            receive(link, bytes[i]);
        }
    }
    if (!link->make_pty &&
        (((got < 0) && (errno != EAGAIN) && (errno != EINTR)) || hung_up(link))) {
        link_lost(link);
    } else {
        (void)push_pending(link);
    }
}

/* Bytes that the peer of a pty has not read yet. The kernel may hold a few more, which are not
 * visible. 0 on a real tty, which the kernel drains by itself. */
static int unread_bytes(const davar_link_t *link)
{
    int unread = 0;
    if (link->make_pty) {
        const int other = open(link->name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        (void)((other >= 0) && (ioctl(other, FIONREAD, &unread) == 0));
        (void)((other >= 0) && (close(other) == 0));
    }
    return unread;
}

/* Closing a pty discards bytes that the peer has not read. This waits until the peer has read them,
 * as long as it makes progress. */
static void drain_tty(davar_link_t *link)
{
    const struct timespec nap = {.tv_nsec = DRAIN_STEP_MS * 1000000L};
    const uint32_t wanted = link->make_pty ? DRAIN_QUIET_STEPS : 1U;
    uint64_t until = link_now_ms() + DRAIN_MS;
    uint32_t quiet = 0;
    int before = 0;
    while ((quiet < wanted) && (link->descriptor >= 0) && !hung_up(link) &&
           (link_now_ms() < until)) {
        const bool all_written = push_pending(link);
        const int unread = unread_bytes(link);
        quiet = (all_written && (unread == 0)) ? quiet + 1U : 0U;
        until = (unread != before) ? link_now_ms() + DRAIN_MS : until;
        before = unread;
        (void)nanosleep(&nap, NULL);
    }
}

const link_kind_t link_tty = {open_tty, send_tty, poll_tty, drain_tty};
