/* davar - stage [3a]: exact power sums of the window and of its first part, kept beside both edges (3.3).
 *
 *        |x x x x x x x x x x x x x|x x x x x|
 *        |<------ first part ----->|<segment>|
 *        |<------------- whole ------------->|
 */
#ifndef DAVAR_SRC_MOMENTS_H
#define DAVAR_SRC_MOMENTS_H

typedef struct {
    powers_t whole; /* on a grid: of all samples, modulo, recorded where an edge can be */
    powers_t first; /* sliding only */
} moments_t;

#endif
