/* davar-sim - small questions about text. */
#ifndef TEXT_H
#define TEXT_H

#include <stdbool.h>

/* First character that is neither space nor tab. */
const char *text_skip_blanks(const char *text);

/* True for spaces and tabs only, or nothing. */
bool text_is_blank(const char *text);

/* Cuts spaces and tabs off the end (in place) and returns the first character that is none. */
char *text_trim(char *text);

/* True when text ends in suffix. */
bool text_ends_with(const char *text, const char *suffix);

#endif
