/* davar tests - Unity on a board: characters go to console.h. */
#ifndef UNITY_CONFIG_H
#define UNITY_CONFIG_H

#include "console.h"

#define UNITY_OUTPUT_CHAR(a) console_put(a)
#define UNITY_OUTPUT_FLUSH() console_flush()

#endif
