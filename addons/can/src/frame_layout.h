/* davar - the place of each signal in its frame: little endian, start bit and width. A test
 * compares it with tools/davar.dbc. */
#ifndef DAVAR_FRAME_LAYOUT_H
#define DAVAR_FRAME_LAYOUT_H

#include "davar/can.h"
#include "number/strict.h"

typedef struct {
    uint16_t start;
    uint8_t bits;
} davar_signal_t;

/* A fixed-point signal: raw = value / unit. All ones means absent. All ones but the
 * last bit means this value or more. */
typedef struct {
    davar_signal_t at;
    float per_unit; /* 1 / unit */
    float unit;
} davar_scaled_t;

/* The highest raw values of an uncertainty of ARW are absent, beyond and the reasons why ARW is
 * absent (davar_noise_t); some are spare. */
#define NOISE_CODES 8U

/* Every frame. */
static const davar_signal_t signal_crc = {0, 8};
static const davar_signal_t signal_counter = {8, 4};
static const davar_signal_t signal_result = {12, 4}; /* not in State, ResultFd and Raw */
static const davar_signal_t signal_value = {32, 32}; /* the float32, or the count */

static const davar_scaled_t scaled_arw_uncertainty = {{16, 16}, 1e4F, 1e-4F};
static const davar_signal_t signal_epoch = {32, 32};
static const davar_signal_t signal_window = {12, 19};
static const davar_signal_t signal_unstable = {31, 1};
static const davar_scaled_t scaled_kurtosis = {{16, 24}, 1e3F, 1e-3F};
static const davar_scaled_t scaled_contribution = {{40, 24}, 1e5F, 1e-5F};
static const davar_signal_t signal_tau_index = {16, 5};
static const davar_scaled_t scaled_adev_uncertainty = {{21, 11}, 1e3F, 1e-3F};
static const davar_signal_t signal_kind = {16, 4};
static const davar_signal_t signal_health_index = {16, 8};
static const davar_signal_t signal_item = {16, 8};
static const davar_signal_t signal_session = {24, 8}; /* DAVAR_End, DAVAR_Health, DAVAR_Setup */
static const davar_signal_t signal_frames = {16, 8};
static const davar_signal_t signal_monitor_index = {16, 8};
static const davar_signal_t signal_worst_tau = {24, 8};
static const davar_signal_t signal_form = {12, 2};
static const davar_signal_t signal_index = {14, 18};
static const davar_signal_t signal_pair[2] = {{32, 16}, {48, 16}};

/* DAVAR_Change. */
static const davar_signal_t signal_change_item = {16, 2};
static const davar_signal_t signal_alarm = {18, 1};
static const davar_signal_t signal_young = {19, 1};
static const davar_signal_t signal_change_m = {20, 12};
static const davar_signal_t signal_cut_age = {32, 20};
static const davar_scaled_t scaled_dispersion = {{52, 12}, 1e2F, 1e-2F};

/* DAVAR_ResultFd. */
static const davar_signal_t fd_window = {12, 19};
static const davar_signal_t fd_unstable = {31, 1};
static const davar_signal_t fd_epoch = {64, 24};
static const davar_scaled_t fd_arw_uncertainty = {{88, 12}, 1e3F, 1e-3F};
static const davar_scaled_t fd_contribution = {{100, 12}, 1e3F, 1e-3F};
static const davar_scaled_t fd_kurtosis = {{112, 16}, 1e3F, 1e-3F};
#define FD_COEFFICIENT 128U /* four float32: Q, B, K, R; ARW is signal_value */
#define FD_ADEV 256U        /* eight float32 */

/* Data bytes of a message; 0: no such message. */
static inline uint8_t message_length(uint32_t message)
{
    if (message == (uint32_t)DAVAR_MESSAGE_RESULT_FD) {
        return 64U;
    }
    return (message < (uint32_t)DAVAR_MESSAGE_COUNT) ? 8U : 0U;
}

#endif
