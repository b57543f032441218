/* davar-sim - JSON lines. */
#include "output/jsonl_out.h"

/* header.c rejects control characters in column names, except tabs. */
static void write_string(rows_out_t *rows, const char *text)
{
    rows_out_put(rows, "\"");
    for (; *text != '\0'; text++) {
        if (*text == '\t') {
            rows_out_put(rows, "\\t");
        } else {
            rows_out_put(rows, ((*text == '"') || (*text == '\\')) ? "\\" : "");
            rows_out_put_character(rows, *text);
        }
    }
    rows_out_put(rows, "\"");
}

void jsonl_out_row(rows_out_t *rows, const fields_t *fields, const char *channel,
                   const epoch_row_t *row)
{
    rows_out_put(rows, "{\"channel\":");
    write_string(rows, channel);
    for (size_t f = 0; f < fields->count; f++) {
        const field_t *field = &fields->field[f];
        const cell_t cell = field->show(row, field->index);
        rows_out_put(rows, ",\"");
        rows_out_put(rows, field->name);
        rows_out_put(rows, "\":");
        rows_out_put_cell(rows, &cell, "null");
    }
    rows_out_put(rows, "}\n");
}
