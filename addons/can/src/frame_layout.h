/* davar - the place of each signal in its frame: little endian, start bit and width.
 * Made from tools/davar.dbc by tools/support/frame_layout.py: do not edit. */
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

/* The frames of 8 bytes: the number that each carries, then every other signal. */
static const davar_signal_t signal_value = {32, 32};
static const davar_signal_t signal_crc = {0, 8};
static const davar_signal_t signal_counter = {8, 4};
static const davar_signal_t signal_result = {12, 4};
static const davar_scaled_t signal_arw_relative_uncertainty = {{16, 16}, 10000.0F, 1e-04F};
static const davar_signal_t signal_window_samples = {12, 19};
static const davar_signal_t signal_unstable = {31, 1};
static const davar_scaled_t signal_kurtosis = {{16, 24}, 1000.0F, 1e-03F};
static const davar_scaled_t signal_contribution = {{40, 24}, 100000.0F, 1e-05F};
static const davar_signal_t signal_tau_index = {16, 5};
static const davar_scaled_t signal_adev_relative_uncertainty = {{21, 11}, 1000.0F, 1e-03F};
static const davar_signal_t signal_kind = {16, 4};
static const davar_signal_t signal_health_index = {16, 8};
static const davar_signal_t signal_session = {24, 8};
static const davar_signal_t signal_item = {16, 8};
static const davar_signal_t signal_monitor_index = {16, 8};
static const davar_signal_t signal_worst_tau = {24, 8};
static const davar_signal_t signal_form = {12, 2};
static const davar_signal_t signal_index = {14, 18};
static const davar_signal_t signal_count0 = {32, 16};
static const davar_signal_t signal_count1 = {48, 16};
static const davar_signal_t signal_change_item = {16, 2};
static const davar_signal_t signal_alarm = {18, 1};
static const davar_signal_t signal_young = {19, 1};
static const davar_signal_t signal_change_cluster_samples = {20, 12};
static const davar_signal_t signal_cut_age = {32, 20};
static const davar_scaled_t signal_dispersion = {{52, 12}, 100.0F, 1e-02F};
static const davar_signal_t signal_frames = {16, 8};
static const davar_signal_t signal_floor_kind = {16, 2};
static const davar_signal_t signal_floor_why = {18, 3};

/* DAVAR_ResultFd, where it differs. */
static const davar_signal_t fd_epoch = {64, 24};
static const davar_scaled_t fd_arw_relative_uncertainty = {{88, 12}, 1000.0F, 1e-03F};
static const davar_scaled_t fd_contribution = {{100, 12}, 1000.0F, 1e-03F};
static const davar_scaled_t fd_kurtosis = {{112, 16}, 1000.0F, 1e-03F};
static const davar_signal_t fd_coefficient[4] = {
    {128, 32}, /* QuantizationDeg */
    {160, 32}, /* BiasInstabilityDegPerH */
    {192, 32}, /* RateRandomWalkDegPerHPerSqrtH */
    {224, 32}, /* RateRampDegPerH2 */
};
static const davar_signal_t fd_adev[8] = {
    {256, 32}, /* Adev0Dps */
    {288, 32}, /* Adev1Dps */
    {320, 32}, /* Adev2Dps */
    {352, 32}, /* Adev3Dps */
    {384, 32}, /* Adev4Dps */
    {416, 32}, /* Adev5Dps */
    {448, 32}, /* Adev6Dps */
    {480, 32}, /* Adev7Dps */
};

/* Data bytes of a message; 0: no such message. */
static inline uint8_t message_length(uint32_t message)
{
    static const uint8_t length[] = {8U, 8U, 8U, 8U, 8U, 8U, 8U, 8U, 64U, 8U, 8U, 8U, 8U};
    return (message < (uint32_t)DAVAR_MESSAGE_COUNT) ? length[message] : 0U;
}

_Static_assert(DAVAR_CAN_BASE == 1488, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_COUNT == 13, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_ARW == 0, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_STATE == 1, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_STATIONARITY == 2, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_ADEV == 3, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_COEFFICIENT == 4, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_HEALTH == 5, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_SETUP == 6, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_MONITOR == 7, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_RESULT_FD == 8, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_RAW == 9, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_CHANGE == 10, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_END == 11, "tools/davar.dbc");
_Static_assert((int)DAVAR_MESSAGE_FLOOR == 12, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_GAPS == 0, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_MISSING_SAMPLES == 1, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_SATURATED_SAMPLES == 2, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_NOT_FINITE_SAMPLES == 3, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_WINDOW_RESTARTS == 4, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_RESULTS_MISSED == 5, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_FRAMES_DROPPED == 6, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_SEND_RETRIES == 7, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_ERROR_PASSIVE == 8, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_BUS_OFF == 9, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_LINK_LOST == 10, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_LINK_BACK == 11, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_NOISE_BYTES == 12, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_EDGES_LOST == 13, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_SOURCE_FAULTS == 14, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_ALARMS == 15, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_WINDOW_CUTS == 16, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_NOISE_ALARMS == 17, "tools/davar.dbc");
_Static_assert((int)DAVAR_HEALTH_SHOCKS_LEFT_OUT == 18, "tools/davar.dbc");

#endif
