/* davar-promise - the memory of a setup on the core that it is for. */
#ifndef MEMORY_H
#define MEMORY_H

/* Prints the sum of macros DAVAR_MEMORY_NAME and DAVAR_CASCADE_MEMORY as "bytes SUM".
 * words: the bytes of a pointer on that core, then pairs of a NAME and its arguments, joined by
 * commas. count: words. Returns the exit status. */
int print_memory(int count, char *words[]);

#endif
