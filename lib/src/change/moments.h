/* davar - stage [3a]: exact power sums, kept by three cursors: the sum over any stretch is the difference of two.
 *
 *      tail                     middle     head
 *        |x x x x x x x x x x x x x|x x x x x|          each cursor: sums of all samples in front of it, modulo
 *        |<------ first part ----->|<segment>|
 */
#ifndef DAVAR_SRC_MOMENTS_H
#define DAVAR_SRC_MOMENTS_H

typedef struct {
    powers_t head; /* on a grid the only one: the others are recorded where they will be needed */
    powers_t middle;
    powers_t tail;
} moments_t;

#endif
