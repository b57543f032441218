/* davar on a bare board - collects Unity's characters and prints them on the host's console line by
 * line. */
#include "console.h"

#include "board.h"

static char line[128];
static size_t used;

void console_flush(void)
{
    line[used] = '\0';
    board_text(line);
    used = 0U;
}

void console_put(int character)
{
    line[used] = (char)character;
    used++;
    if ((character == '\n') || (used == (sizeof line - 1U))) {
        console_flush();
    }
}
