/* davar-sim - CSV. */
#include "output/csv_out.h"

void csv_out_header(rows_out_t *rows, const fields_t *fields, bool with_channel)
{
    rows_out_put(rows, with_channel ? "channel," : "");
    for (size_t f = 0; f < fields->count; f++) {
        rows_out_put(rows, (f > 0U) ? "," : "");
        rows_out_put(rows, fields->field[f].name);
    }
    rows_out_put(rows, "\n");
}

void csv_out_row(rows_out_t *rows, const fields_t *fields, const char *channel,
                 const epoch_row_t *row)
{
    if (channel != NULL) {
        rows_out_put(rows, channel);
        rows_out_put_character(rows, ',');
    }
    for (size_t f = 0; f < fields->count; f++) {
        const field_t *field = &fields->field[f];
        const cell_t cell = field->show(row, field->index);
        if (f > 0U) {
            rows_out_put_character(rows, ',');
        }
        rows_out_put_cell(rows, &cell, "");
    }
    rows_out_put_character(rows, '\n');
}
