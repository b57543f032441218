/* davar on a bare board - where Unity writes; its configuration names these two functions. */
#ifndef CONSOLE_H
#define CONSOLE_H

void console_put(int character);
void console_flush(void);

#endif
