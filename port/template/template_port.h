/* davar port template - a port to copy: it compiles as it is, for every target. Rename it, then fill what says "here".
 * What each function must do stands in port/include/davar_port.h; docs/PORTING.md walks through it.
 *
 *   transfer (DMA) -> half 0 | half 1 -> template_port_half_done (its interrupt) -> read -> node */
#ifndef TEMPLATE_PORT_H
#define TEMPLATE_PORT_H

#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TEMPLATE_PORT_HALF 32U /* samples per half of the buffer */

/* One sensor channel of int16 counts. Belongs to the caller, must outlive the port. */
typedef struct {
    int16_t counts[2][TEMPLATE_PORT_HALF]; /* the transfer goes round and round in here */
    volatile uint32_t filled;              /* halves that are full, ever */
    uint32_t read;                         /* halves that were handed out or missed, ever */
    davar_port_samples_t samples;
} template_port_t;

/* A port around `state`. */
davar_port_t template_port(template_port_t *state);

/* From the transfer's interrupt, each time one half is full. The node must be done with a half before the other is full;
 * when it was not, the next block says how much is missing. */
void template_port_half_done(template_port_t *state);

#ifdef __cplusplus
}
#endif

#endif
