/* davar for Linux - SocketCAN. Receives error frames only. */
#include "link.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

static bool set_options(int descriptor, bool fd)
{
    const can_err_mask_t errors = CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;
    const int on = 1;
    return (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0) == 0) &&
           (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0) &&
           (!fd || (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) == 0));
}

/* Binding to an interface that is down succeeds, but frames would be lost. This checks it. */
static bool bind_interface(int descriptor, const davar_link_t *link)
{
    struct ifreq request = {0};
    struct sockaddr_can address = {.can_family = AF_CAN};
    memcpy(request.ifr_name, link->name,
           strlen(link->name)); /* shorter than IFNAMSIZ, see open_can */
    if (ioctl(descriptor, SIOCGIFINDEX, &request) != 0) {
        return false;
    }
    address.can_ifindex = request.ifr_ifindex;
    if ((ioctl(descriptor, SIOCGIFMTU, &request) != 0) ||
        (link->options.fd && (request.ifr_mtu < (int)CANFD_MTU))) {
        errno = EMSGSIZE;
        return false;
    }
    if ((ioctl(descriptor, SIOCGIFFLAGS, &request) != 0) || ((request.ifr_flags & IFF_UP) == 0)) {
        errno = ENETDOWN;
        return false;
    }
    return bind(descriptor, (const struct sockaddr *)&address, sizeof address) == 0;
}

static bool open_can(davar_link_t *link, char *why, size_t size)
{
    if (strlen(link->name) >= IFNAMSIZ) {
        (void)snprintf(why, size, "%s%s: no interface has such a long name", link->prefix,
                       link->name);
        return false;
    }
    const int descriptor = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if ((descriptor < 0) || !set_options(descriptor, link->options.fd) ||
        !bind_interface(descriptor, link)) {
        const char *cause =
            (errno == EMSGSIZE) ? "the interface is not set to CAN FD (mtu 72)" : strerror(errno);
        (void)snprintf(why, size, "%s%s: %s", link->prefix, link->name, cause);
        (void)((descriptor >= 0) && (close(descriptor) == 0));
        return false;
    }
    link->descriptor = descriptor;
    return true;
}

/* While the bus is off, the kernel accepts frames and discards them. This therefore sends no frames
 * then. */
static davar_port_send_t send_can(davar_link_t *link, const davar_packet_t *packet)
{
    if (link->off) {
        return DAVAR_PORT_SEND_AGAIN;
    }
    const bool fd = packet->length > 8U;
    const uint32_t extended = (link->dialect != NULL) ? CAN_EFF_FLAG : 0U;
    struct canfd_frame out = {.can_id = packet->identifier | extended,
                              .len = packet->length,
                              .flags = fd ? CANFD_BRS : 0U}; /* data at the fast rate */
    memcpy(out.data, packet->data, packet->length);
    const size_t size = fd ? CANFD_MTU : CAN_MTU;
    if (write(link->descriptor, &out, size) == (ssize_t)size) {
        return DAVAR_PORT_SEND_DONE;
    }
    if ((errno == ENOBUFS) || (errno == EAGAIN) || (errno == EINTR)) {
        return DAVAR_PORT_SEND_AGAIN;
    }
    link_lost(link);
    return DAVAR_PORT_SEND_FAULT;
}

static void note_error(davar_link_t *link, const struct can_frame *frame)
{
    const bool control = (frame->can_id & CAN_ERR_CRTL) != 0U;
    const bool passive =
        control && ((frame->data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0U);
    if (passive && !link->passive) {
        link_count(link, DAVAR_HEALTH_ERROR_PASSIVE, 1U);
    }
    link->passive = control ? passive : link->passive;
    if ((frame->can_id & CAN_ERR_BUSOFF) != 0U) {
        link_count(link, DAVAR_HEALTH_BUS_OFF, link->off ? 0U : 1U);
        link->off = true;
        link->recovering = false;
    } else { /* any later state: restarted, active, passive */
        link->recovering = link->off;
    }
}

/* True if the interface carries frames. From bus-off to restart it does not. */
static bool has_carrier(const davar_link_t *link)
{
    char path[sizeof "/sys/class/net//carrier" + LINK_NAME_BYTES];
    char answer = '1';
    (void)snprintf(path, sizeof path, "/sys/class/net/%s/carrier", link->name);
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    (void)((descriptor >= 0) && (read(descriptor, &answer, 1U) == 1));
    (void)((descriptor >= 0) && (close(descriptor) == 0));
    return answer == '1';
}

static void watch_recovery(davar_link_t *link)
{
    if (link->off && link->recovering && has_carrier(link)) {
        link_count(link, DAVAR_HEALTH_LINK_BACK, 1U);
        link->off = false;
        link->recovering = false;
    }
}

static void poll_can(davar_link_t *link)
{
    struct can_frame frame;
    ssize_t got = 0;
    while ((got = read(link->descriptor, &frame, sizeof frame)) == (ssize_t)sizeof frame) {
        if ((frame.can_id & CAN_ERR_FLAG) != 0U) {
            note_error(link, &frame);
        }
    }
    if ((got < 0) && (errno != EAGAIN) && (errno != EINTR)) {
        link_lost(link); /* ENETDOWN, ENODEV: the socket reports this once */
    }
    watch_recovery(link);
}

static void drain_can(davar_link_t *link)
{
    (void)link; /* the kernel's queue outlives the socket */
}

const link_kind_t link_can = {open_can, send_can, poll_can, drain_can};
