/* davar - how much more the blocks scatter than in Gaussian noise, and the factor by which that
 * widens a threshold (10.3). */
#include "core/window.h"
#include "laws/glr.h"
#include "number/real.h"

#define F_MOST ((16U * F_ONE) - 1U)
#define F_BODY (F_ONE + (F_ONE / 4U)) /* above this phi, few blocks have a larger f than many */
#define PHI_ONE (UINT32_C(1) << 24U)
#define LEAST (PHI_ONE / 4U) /* large enough for phi to move in spite of CUT */
#define MOST (PHI_ONE * 14U)
#define CUT 9U /* a step weighs at most this many phi */
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
    const uint32_t size =
        ((step < 0) ? (0U - (uint32_t)step) : (uint32_t)step) >> 12U; /* 12 digits */
    const uint32_t most = CUT * phi;
    if (size > UINT16_MAX) {
        return most;
    }
    const uint64_t square = davar_multiply_u32(size * size, unit) >> 16U;
    return (square < most) ? (uint32_t)square : most;
}

void davar_dispersion_learn(davar_dispersion_t *dispersion, int32_t logarithm, uint32_t unit,
                            uint32_t memory)
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
    const uint32_t moved = (square > phi) ? (phi + move) : (phi - move);
    dispersion->phi = (moved < LEAST) ? LEAST : smaller(moved, MOST);
    dispersion->count += forgets ? 0U : 1U;
}

uint32_t davar_glr_dispersion(const davar_glr_t *state, uint32_t octave)
{
    const uint32_t larger =
        (state->single.phi > state->of_8.phi) ? state->single.phi : state->of_8.phi;
    const uint32_t phi = larger >> (24U - GAIN_DIGITS);
    if (phi <= F_ONE) {
        return F_ONE;
    }
    const uint32_t heavy = (phi > F_BODY) ? (phi - F_BODY) : 0U;
    return smaller(phi + ((phi - F_ONE + heavy) / 8U) + ((4U * heavy) >> octave), F_MOST);
}
