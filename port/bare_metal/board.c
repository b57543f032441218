/* davar on a bare board - words of the command line and figures, the same on every board. */
#include "board.h"

size_t board_words(char *text, size_t bytes, char *words[], size_t most)
{
    size_t count = 0U;
    board_command_line(text, bytes);
    for (char *at = text; (*at != '\0') && (count < most); count++) {
        words[count] = at;
        while ((*at != '\0') && (*at != ' ')) {
            at++;
        }
        while (*at == ' ') {
            *at = '\0';
            at++;
        }
    }
    return count;
}

void board_figure(const char *name, uint32_t value)
{
    char digits[12] = "";
    size_t at = sizeof digits - 1U;
    uint32_t rest = value;
    do {
        at--;
        digits[at] = (char)('0' + (rest % 10U));
        rest /= 10U;
    } while (rest > 0U);
    board_text(name);
    board_text(" ");
    board_text(&digits[at]);
    board_text("\n");
}
