/* davar-sim - text helpers. */
#include "common/text.h"

#include <string.h>

static bool is_blank(char c)
{
    return (c == ' ') || (c == '\t');
}

const char *text_skip_blanks(const char *text)
{
    while (is_blank(*text)) {
        text++;
    }
    return text;
}

bool text_is_blank(const char *text)
{
    return *text_skip_blanks(text) == '\0';
}

char *text_trim(char *text)
{
    while (is_blank(*text)) {
        text++;
    }
    size_t length = strlen(text);
    while ((length > 0U) && is_blank(text[length - 1U])) {
        length--;
    }
    text[length] = '\0';
    return text;
}

bool text_ends_with(const char *text, const char *suffix)
{
    const size_t length = strlen(text);
    const size_t wanted = strlen(suffix);
    return (length >= wanted) && (strcmp(text + length - wanted, suffix) == 0);
}
