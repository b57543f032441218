/* davar tests - which samples policy glr accepts, told by a detector of the test's own that hears the raw ones (unit/test_glr.c holds it to
 * the law), and sums over them made anew: integers from cumulative sums, another road than the library's. */
#ifndef DAVAR_TESTS_ACCEPTED_H
#define DAVAR_TESTS_ACCEPTED_H

#include "davar/davar.h"
#include "detector/glr.h"

#define ACCEPTED_RING 4096U /* samples that are remembered; a power of two */

typedef struct {
    davar_glr_config_t config;
    davar_glr_t detector;
    int32_t
        waiting[GLR_BLOCK_MAX * (GLR_SHOCK_MAX + 2U)]; /* what has come and is not accepted yet */
    uint32_t waits;
    uint64_t now; /* samples that came */
    uint32_t cuts;
    uint32_t alarms;
    uint32_t shocks;
    int64_t phase[ACCEPTED_RING];   /* cumulative sums up to accepted sample n */
    uint32_t run[ACCEPTED_RING];    /* samples without a boundary up to it */
    uint64_t moment[ACCEPTED_RING]; /* when it came */
    uint64_t count;                 /* accepted */
    bool is_behind_boundary;        /* the next one is */
} accepted_t;

void accepted_start(accepted_t *accepted, const davar_config_t *config);

void accepted_hear(accepted_t *accepted, int32_t sample);

/* What waits is left out with the gap. */
void accepted_gap(accepted_t *accepted);

/* The record is at its end: what waits goes on, unless a shock may have begun. */
void accepted_end(accepted_t *accepted);

/* One behind the accepted sample that came at `epoch`; 0: none did. */
uint64_t accepted_head(const accepted_t *accepted, uint64_t epoch);

/* Are the samples [tail, head) accepted ones, among them that of a centred window's epoch (10.15)? It came as many accepted samples before
 * the newest of its time as the epoch lies behind that. In the last, incomplete block of a record the window ends in front of it. */
bool accepted_holds(const accepted_t *accepted, uint64_t tail, uint64_t head, uint64_t epoch);

/* Sum of D^2 over the accepted samples [tail, head) and its count; none spans a boundary. D = P[i] - 2 P[i - m] + P[i - 2 m]. Exact below
 * 2^53, and to a rounding of each 64 bits above. */
double accepted_sum(const accepted_t *accepted, uint64_t tail, uint64_t head, uint32_t m,
                    uint32_t *differences);

#endif
