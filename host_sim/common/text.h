/* davar-sim - small text functions. */
#ifndef TEXT_H
#define TEXT_H

#include <stdbool.h>

/* First character that is neither space nor tab. */
const char *text_skip_blanks(const char *text);

/* True if the text is empty or has only spaces and tabs. */
bool text_is_blank(const char *text);

/* Removes spaces and tabs at the end (in place) and returns the first character that is neither. */
char *text_trim(char *text);

/* True if text ends in suffix. */
bool text_ends_with(const char *text, const char *suffix);

#endif
