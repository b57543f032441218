/* davar on a bare board - the one trapping instruction. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stdint.h>

intptr_t semihosting_call(int operation, const void *parameters);

#endif
