/* davar-sim - JSON lines. */
#include "jsonl_out.h"

/* Column names hold no control characters but tabs (header.c sees to that). */
static void write_string(FILE *file, const char *text)
{
    (void)fputc('"', file);
    for (; *text != '\0'; text++) {
        if (*text == '\t') {
            (void)fputs("\\t", file);
        } else {
            (void)fputs(((*text == '"') || (*text == '\\')) ? "\\" : "", file);
            (void)fputc(*text, file);
        }
    }
    (void)fputc('"', file);
}

void jsonl_out_row(FILE *file, const fields_t *fields, const char *channel, const epoch_row_t *row)
{
    char text[CELL_TEXT_BYTES];
    (void)fputs("{\"channel\":", file);
    write_string(file, channel);
    for (size_t f = 0; f < fields->count; f++) {
        const field_t *field = &fields->field[f];
        const cell_t cell = field->show(row, field->index);
        (void)fprintf(file, ",\"%s\":%s", field->name, cell_text(&cell, "null", text));
    }
    (void)fputs("}\n", file);
}
