/* davar-sim - the help text, which is the manual. */
#ifndef USAGE_H
#define USAGE_H

#include <stdio.h>

void usage_print(FILE *file);
void version_print(FILE *file);

#endif
