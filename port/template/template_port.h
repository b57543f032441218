/* davar port template - a port to copy. It compiles unchanged for every target. Rename it, then
 * fill in the places marked "Here". port/include/davar_port.h specifies each function;
 * docs/PORTING.md explains the steps.
 *
 *   transfer (DMA) -> half 0 | half 1 -> template_port_half_done (its interrupt) -> read -> node */
#ifndef TEMPLATE_PORT_H
#define TEMPLATE_PORT_H

#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TEMPLATE_PORT_HALF 32U /* samples per half of the buffer */

/* One sensor channel of int16 counts. The caller owns it; it must outlive the port. */
typedef struct {
    int16_t counts[2][TEMPLATE_PORT_HALF]; /* target of the circular transfer */
    volatile uint32_t filled;              /* halves filled so far */
    uint32_t read;                         /* halves returned or missed so far */
    davar_port_samples_t samples;
} template_port_t;

/* Makes a port for `state`. */
davar_port_t template_port(template_port_t *state);

/* Call it from the transfer's interrupt each time one half is full. The node must finish a half
 * before the other one is full. If it does not, the next block reports the missing samples. */
void template_port_half_done(template_port_t *state);

#ifdef __cplusplus
}
#endif

#endif
