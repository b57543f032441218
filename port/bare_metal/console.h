/* davar on a bare board - Unity's output; its configuration uses these two functions. */
#ifndef CONSOLE_H
#define CONSOLE_H

void console_put(int character);
void console_flush(void);

#endif
