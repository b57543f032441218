/* davar-promise - the memory of a setup on the core that it is for. */
#ifndef MEMORY_H
#define MEMORY_H

/* Prints a macro DAVAR_MEMORY (Q15), DAVAR_MEMORY_GRID (GRID_Q15), DAVAR_MEMORY_GLR (GLR_Q15) or
 * DAVAR_CASCADE_MEMORY (CASCADE_Q15) as "bytes N". words: the bytes of a pointer on that core, that
 * name, and the arguments, joined by commas. count: words. Returns the exit status. */
int print_memory(int count, char *words[]);

#endif
