/* davar - how much wider than Gaussian noise's the blocks scatter. */
#include "track/dispersion.h"

#include "number/real.h"

#define PHI_ONE (UINT32_C(1) << 24U)
#define LEAST (PHI_ONE / 4U) /* so that the cut below never keeps phi where it is */
#define MOST (PHI_ONE * 14U)
#define CUT 9U /* times phi: the most that one step can weigh */
#define BEGIN 15U

void davar_dispersion_start(davar_dispersion_t *dispersion)
{
    dispersion->phi = PHI_ONE;
    dispersion->before = 0;
    dispersion->count = 0U;
}

/* step^2 unit, at most 9 phi */
static uint32_t square_of(int32_t step, uint32_t unit, uint32_t phi)
{
    const uint32_t size = ((step < 0) ? (0U - (uint32_t)step) : (uint32_t)step) >> 12U; /* 12 digits */
    const uint32_t most = CUT * phi;
    if (size > UINT16_MAX) {
        return most;
    }
    const uint64_t square = davar_multiply_u32(size * size, unit) >> 16U;
    return (square < most) ? (uint32_t)square : most;
}

static uint32_t limited(uint32_t phi)
{
    return (phi < LEAST) ? LEAST : ((phi > MOST) ? MOST : phi);
}

void davar_dispersion_learn(davar_dispersion_t *dispersion, int32_t logarithm, uint32_t unit, uint32_t memory)
{
    const int32_t step = logarithm - dispersion->before;
    dispersion->before = logarithm;
    if (dispersion->count == 0U) {
        dispersion->count = 1U;
        return;
    }
    const uint32_t phi = dispersion->phi;
    const uint32_t square = square_of(step, unit, phi);
    const uint32_t distance = (square > phi) ? (square - phi) : (phi - square);
    const uint32_t n = dispersion->count + BEGIN;
    const bool forgets = ((n >> memory) != 0U);
    const uint32_t move = forgets ? (distance >> memory) : davar_divided(distance, n);
    dispersion->phi = limited((square > phi) ? (phi + move) : (phi - move));
    dispersion->count += forgets ? 0U : 1U;
}
