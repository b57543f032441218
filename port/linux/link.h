/* davar for Linux - the common part of the kinds of link. */
#ifndef LINUX_LINK_H
#define LINUX_LINK_H

#include "davar_link.h"

#include <sys/socket.h>

#define LINK_NAME_BYTES 256U
#define LINK_TEXT_BYTES 128U
#define LINK_RETRY_MS 100U /* between attempts to reopen */

/* Functions of one kind of link. */
typedef struct {
    bool (*open)(davar_link_t *link, char *why,
                 size_t size); /* false: not available (yet); nothing stays open */
    davar_port_send_t (*send)(davar_link_t *link, const davar_packet_t *packet);
    void (*poll)(davar_link_t *link);
    void (*drain)(davar_link_t *link);
} link_kind_t;

struct davar_link {
    const link_kind_t *kind;
    davar_link_options_t options;
    const char *prefix;              /* what stands before the name */
    const davar_dialect_t *dialect;  /* null: davar's own frames */
    char name[LINK_NAME_BYTES];      /* interface, path or HOST:PORT */
    int descriptor;                  /* -1: lost */
    bool peer;                       /* pty: a peer has opened it; UDP: none has refused a packet */
    struct sockaddr_storage address; /* UDP: of the peer, resolved once */
    socklen_t address_bytes;         /* UDP: 0 before that */
    bool make_pty;
    bool may_wait;     /* a link that is not there yet may come */
    bool passive;      /* CAN: error passive now */
    bool off;          /* CAN: bus off now */
    bool recovering;   /* CAN: the bus was off, and a later state was reported */
    uint64_t retry_ms; /* UDP: time of the first packet after the last refused one, or 0 */
    size_t pending;    /* tty: characters that a short write did not send */
    char text[LINK_TEXT_BYTES];
    size_t received; /* tty: characters of the line being received */
    bool odd;        /* tty: the line is not SLCAN */
    uint32_t count[DAVAR_HEALTH_COUNT];
};

extern const link_kind_t link_can;
extern const link_kind_t link_tty;
extern const link_kind_t link_udp;

void link_count(davar_link_t *link, davar_health_item_t item, uint32_t by);

/* The pending line or packet will never be completed: it is counted as dropped. */
void link_give_up(davar_link_t *link);

/* Closes the descriptor and counts the loss. */
void link_lost(davar_link_t *link);

uint64_t link_now_ms(void);

#endif
