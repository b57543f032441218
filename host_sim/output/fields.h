/* davar-sim - the output columns: names and values. One list for every format. */
#ifndef FIELDS_H
#define FIELDS_H

#include "davar/floor.h"
#include "davar/glr.h"
#include "davar/monitor.h"

#define FIELDS_MAX (41U + 6U * DAVAR_TAUS_MAX)
#define FIELD_NAME_BYTES 48U

/* Places that every choice of columns has. */
#define FIELD_EPOCH 0U
#define FIELD_UNSTABLE 5U

typedef enum {
    CELL_ABSENT = 0, /* the window cannot support this value */
    CELL_INTEGER,
    CELL_TIME, /* seconds, all digits */
    CELL_NUMBER
} cell_kind_t;

typedef struct {
    cell_kind_t kind;
    union {
        uint64_t integer;
        double number;
    };
} cell_t;

/* The data of one row. */
typedef struct {
    const davar_result_t *result;
    const davar_glr_report_t *report;  /* null: centred windows, which have no law glr */
    const davar_misfit_t *misfit;      /* null: no model to compare with */
    const davar_floor_result_t *floor; /* null: no --floor */
    double time_s;
} epoch_row_t;

typedef struct {
    char name[FIELD_NAME_BYTES];
    cell_t (*show)(const epoch_row_t *row, uint32_t index);
    uint32_t index; /* which tau or coefficient */
    bool of_fit;    /* the fit gives it */
} field_t;

typedef struct {
    size_t count;
    size_t first_adev;         /* the deviations, one field per tau, in a row */
    field_t field[FIELDS_MAX]; /* from the epoch on */
} fields_t;

/* The choice of columns depends on this. */
typedef struct {
    const uint32_t *taus;
    uint8_t tau_count;
    bool monitored; /* results are compared with an error model */
    bool tracked;   /* law glr */
    bool floored;   /* --floor */
    bool unfitted;  /* no fields of the fit */
    /* also intervals, difference counts, gaps, upper bounds, mean deviations from the model */
    bool details;
} fields_setup_t;

void fields_make(fields_t *fields, const fields_setup_t *setup);

/* Writes the text of a cell, `%.9g` for numbers, or `absent` for an absent value. `text` has
 * DECIMAL_TEXT_BYTES. Returns the length. */
size_t cell_print(const cell_t *cell, const char *absent, char *text);

#endif
