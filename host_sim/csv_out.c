/* davar-sim - CSV. */
#include "csv_out.h"

void csv_out_header(FILE *file, const fields_t *fields, bool with_channel)
{
    (void)fputs(with_channel ? "channel," : "", file);
    for (size_t f = 0; f < fields->count; f++) {
        (void)fputs((f > 0U) ? "," : "", file);
        (void)fputs(fields->field[f].name, file);
    }
    (void)fputc('\n', file);
}

void csv_out_row(FILE *file, const fields_t *fields, const char *channel, const epoch_row_t *row)
{
    char text[CELL_TEXT_BYTES];
    if (channel != NULL) {
        (void)fputs(channel, file);
        (void)fputc(',', file);
    }
    for (size_t f = 0; f < fields->count; f++) {
        const field_t *field = &fields->field[f];
        const cell_t cell = field->show(row, field->index);
        (void)fputs((f > 0U) ? "," : "", file);
        (void)fputs(cell_text(&cell, "", text), file);
    }
    (void)fputc('\n', file);
}
