/* davar-sim - output columns, in the order of the output. */
#include "output/fields.h"

#include "common/decimal.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static cell_t integer_cell(uint64_t integer)
{
    return (cell_t){.kind = CELL_INTEGER, .integer = integer};
}

static cell_t number_cell(double number)
{
    return (cell_t){.kind = isfinite(number) ? CELL_NUMBER : CELL_ABSENT, .number = number};
}

static cell_t present_cell(bool present, double number)
{
    return present ? number_cell(number) : (cell_t){.kind = CELL_ABSENT};
}

static cell_t show_epoch(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->result->epoch);
}

static cell_t show_time(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return (cell_t){.kind = isfinite(row->time_s) ? CELL_TIME : CELL_ABSENT, .number = row->time_s};
}

static cell_t show_window(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->result->window_samples);
}

static cell_t show_kurtosis(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->result->kurtosis);
}

static cell_t show_contribution(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->result->contribution);
}

static cell_t show_unstable(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->result->unstable ? 1U : 0U);
}

static cell_t show_alarm(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->report->alarm ? 1U : 0U);
}

static cell_t show_cut_age(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->report->cut_age_samples);
}

static cell_t show_dispersion(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->result->dispersion);
}

static cell_t show_young(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->report->young ? 1U : 0U);
}

static cell_t show_changed(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return (row->report->change.m > 0U) ? integer_cell(row->report->change.m)
                                        : (cell_t){.kind = CELL_ABSENT};
}

static cell_t show_older(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->change.older);
}

static cell_t show_newer(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->change.newer);
}

static cell_t show_gain(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->change.gain);
}

static cell_t show_steady_samples(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->report->steady.samples);
}

static cell_t show_steady(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->steady.level);
}

static cell_t show_steady_low(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->steady.low);
}

static cell_t show_steady_high(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->report->steady.high);
}

static cell_t show_gaps(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell(row->result->gaps_in_window);
}

static cell_t show_coarse(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell((row->result->noise == DAVAR_NOISE_COARSE) ? 1U : 0U);
}

static cell_t show_filtered(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell((row->result->noise == DAVAR_NOISE_FILTERED) ? 1U : 0U);
}

static cell_t show_flat(const epoch_row_t *row, uint32_t end)
{
    return integer_cell((end == 0U) ? row->result->flat_from : row->result->flat_to);
}

static cell_t show_coefficient(const epoch_row_t *row, uint32_t kind)
{
    const davar_coefficient_t *coefficient = &row->result->coefficient[kind];
    return present_cell(coefficient->present, coefficient->value);
}

static cell_t show_coefficient_low(const epoch_row_t *row, uint32_t kind)
{
    const davar_coefficient_t *coefficient = &row->result->coefficient[kind];
    return present_cell(coefficient->present, coefficient->low);
}

static cell_t show_coefficient_high(const epoch_row_t *row, uint32_t kind)
{
    const davar_coefficient_t *coefficient = &row->result->coefficient[kind];
    return present_cell(coefficient->present, coefficient->high);
}

static cell_t show_coefficient_upper(const epoch_row_t *row, uint32_t kind)
{
    const davar_coefficient_t *coefficient = &row->result->coefficient[kind];
    return present_cell(!coefficient->present, coefficient->high);
}

static cell_t show_adev(const epoch_row_t *row, uint32_t t)
{
    return present_cell(row->result->tau[t].differences > 0U, row->result->tau[t].adev);
}

static cell_t show_adev_low(const epoch_row_t *row, uint32_t t)
{
    return present_cell(row->result->tau[t].differences > 0U, row->result->tau[t].low);
}

static cell_t show_adev_high(const epoch_row_t *row, uint32_t t)
{
    return present_cell(row->result->tau[t].differences > 0U, row->result->tau[t].high);
}

static cell_t show_differences(const epoch_row_t *row, uint32_t t)
{
    return integer_cell(row->result->tau[t].differences);
}

static cell_t show_model_health(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell(row->misfit->health);
}

static cell_t show_model_deviation(const epoch_row_t *row, uint32_t t)
{
    return number_cell(row->misfit->tau[t].deviation);
}

static cell_t show_model_mean_deviation(const epoch_row_t *row, uint32_t t)
{
    return number_cell(row->misfit->tau[t].mean_deviation);
}

static cell_t show_floor(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell((double)row->floor->value);
}

static cell_t show_floor_low(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell((double)row->floor->low);
}

static cell_t show_floor_high(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return number_cell((row->floor->high < HUGE_VALF) ? (double)row->floor->high : (double)NAN);
}

static cell_t show_floor_why(const epoch_row_t *row, uint32_t index)
{
    (void)index;
    return integer_cell((uint64_t)row->floor->why);
}

static const field_t COMMON[] = {
    [FIELD_EPOCH] = {"epoch", show_epoch, 0U, false},
    {"time_s", show_time, 0U, false},
    {"window_samples", show_window, 0U, false},
    {"kurtosis", show_kurtosis, 0U, false},
    {"contribution", show_contribution, 0U, false},
    [FIELD_UNSTABLE] = {"unstable", show_unstable, 0U, false},
    {"arw_deg_per_sqrt_h", show_coefficient, DAVAR_ANGLE_RANDOM_WALK, true},
    {"arw_low_deg_per_sqrt_h", show_coefficient_low, DAVAR_ANGLE_RANDOM_WALK, true},
    {"arw_high_deg_per_sqrt_h", show_coefficient_high, DAVAR_ANGLE_RANDOM_WALK, true},
    {"bi_deg_per_h", show_coefficient, DAVAR_BIAS_INSTABILITY, true},
    {"rrw_deg_per_h_per_sqrt_h", show_coefficient, DAVAR_RATE_RANDOM_WALK, true},
    {"rr_deg_per_h2", show_coefficient, DAVAR_RATE_RAMP, true},
    {"qn_deg", show_coefficient, DAVAR_QUANTIZATION, true},
    {"filtered", show_filtered, 0U, true},
};

static const field_t TRACKING[] = {
    {"alarm", show_alarm, 0U, false},
    {"cut_age_samples", show_cut_age, 0U, false},
    {"dispersion", show_dispersion, 0U, false},
    {"change_m", show_changed, 0U, false},
    {"change_older", show_older, 0U, false},
    {"change_newer", show_newer, 0U, false},
    {"change_gain", show_gain, 0U, false},
    {"young", show_young, 0U, false},
    {"steady_samples", show_steady_samples, 0U, false},
    {"steady", show_steady, 0U, false},
    {"steady_low", show_steady_low, 0U, false},
    {"steady_high", show_steady_high, 0U, false},
};

static const field_t FLOOR[] = {
    {"floor_deg_per_sqrt_h", show_floor, 0U, false},
    {"floor_low_deg_per_sqrt_h", show_floor_low, 0U, false},
    {"floor_high_deg_per_sqrt_h", show_floor_high, 0U, false},
    {"floor_why", show_floor_why, 0U, false},
};

static const field_t DETAILS[] = {
    {"gaps_in_window", show_gaps, 0U, false},
    {"coarse", show_coarse, 0U, true},
    {"flat_from", show_flat, 0U, true},
    {"flat_to", show_flat, 1U, true},
    {"arw_upper_deg_per_sqrt_h", show_coefficient_upper, DAVAR_ANGLE_RANDOM_WALK, true},
    {"bi_upper_deg_per_h", show_coefficient_upper, DAVAR_BIAS_INSTABILITY, true},
    {"rrw_upper_deg_per_h_per_sqrt_h", show_coefficient_upper, DAVAR_RATE_RANDOM_WALK, true},
    {"rr_upper_deg_per_h2", show_coefficient_upper, DAVAR_RATE_RAMP, true},
    {"qn_upper_deg", show_coefficient_upper, DAVAR_QUANTIZATION, true},
    {"bi_low_deg_per_h", show_coefficient_low, DAVAR_BIAS_INSTABILITY, true},
    {"bi_high_deg_per_h", show_coefficient_high, DAVAR_BIAS_INSTABILITY, true},
    {"rrw_low_deg_per_h_per_sqrt_h", show_coefficient_low, DAVAR_RATE_RANDOM_WALK, true},
    {"rrw_high_deg_per_h_per_sqrt_h", show_coefficient_high, DAVAR_RATE_RANDOM_WALK, true},
    {"rr_low_deg_per_h2", show_coefficient_low, DAVAR_RATE_RAMP, true},
    {"rr_high_deg_per_h2", show_coefficient_high, DAVAR_RATE_RAMP, true},
    {"qn_low_deg", show_coefficient_low, DAVAR_QUANTIZATION, true},
    {"qn_high_deg", show_coefficient_high, DAVAR_QUANTIZATION, true},
};

static void add_all(fields_t *fields, const fields_setup_t *setup, const field_t *list,
                    size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!list[i].of_fit || !setup->unfitted) {
            fields->field[fields->count] = list[i];
            fields->count++;
        }
    }
}

static void add_tau(fields_t *fields, const fields_setup_t *setup, const char *what, uint32_t m,
                    field_t field)
{
    (void)snprintf(field.name, sizeof field.name, "%s_%" PRIu32, what, m);
    add_all(fields, setup, &field, 1U);
}

static void add_monitor(fields_t *fields, const fields_setup_t *setup)
{
    const field_t health = {"model_health", show_model_health, 0U, true};
    add_all(fields, setup, &health, 1U);
    for (uint32_t t = 0; t < setup->tau_count; t++) {
        add_tau(fields, setup, "model_deviation", setup->taus[t],
                (field_t){.show = show_model_deviation, .index = t, .of_fit = true});
    }
}

static void add_details(fields_t *fields, const fields_setup_t *setup)
{
    for (uint32_t t = 0; t < setup->tau_count; t++) {
        const uint32_t m = setup->taus[t];
        add_tau(fields, setup, "adev_low", m,
                (field_t){.show = show_adev_low, .index = t, .of_fit = true});
        add_tau(fields, setup, "adev_high", m,
                (field_t){.show = show_adev_high, .index = t, .of_fit = true});
        add_tau(fields, setup, "differences", m, (field_t){.show = show_differences, .index = t});
    }
    add_all(fields, setup, DETAILS, sizeof DETAILS / sizeof DETAILS[0]);
    for (uint32_t t = 0; setup->monitored && (t < setup->tau_count); t++) {
        add_tau(fields, setup, "model_mean_deviation", setup->taus[t],
                (field_t){.show = show_model_mean_deviation, .index = t, .of_fit = true});
    }
}

void fields_make(fields_t *fields, const fields_setup_t *setup)
{
    fields->count = 0;
    add_all(fields, setup, COMMON, sizeof COMMON / sizeof COMMON[0]);
    if (setup->tracked) {
        add_all(fields, setup, TRACKING, sizeof TRACKING / sizeof TRACKING[0]);
    }
    if (setup->floored) {
        add_all(fields, setup, FLOOR, sizeof FLOOR / sizeof FLOOR[0]);
    }
    fields->first_adev = fields->count;
    for (uint32_t t = 0; t < setup->tau_count; t++) {
        add_tau(fields, setup, "adev", setup->taus[t], (field_t){.show = show_adev, .index = t});
    }
    if (setup->monitored) {
        add_monitor(fields, setup);
    }
    if (setup->details) {
        add_details(fields, setup);
    }
}

size_t cell_print(const cell_t *cell, const char *absent, char *text)
{
    switch (cell->kind) {
    case CELL_INTEGER:
        return decimal_print_whole(cell->integer, text);
    case CELL_TIME:
        return decimal_print(cell->number, 15, text);
    case CELL_NUMBER:
        return decimal_print(cell->number, 9, text);
    case CELL_ABSENT:
    default: {
        const size_t length = strlen(absent);
        memcpy(text, absent, length + 1U);
        return length;
    }
    }
}
