/* davar - version: the one place where it is written. CMake reads this file. */
#ifndef DAVAR_VERSION_H
#define DAVAR_VERSION_H

#define DAVAR_VERSION_MAJOR 0
#define DAVAR_VERSION_MINOR 1
#define DAVAR_VERSION_PATCH 0

/* As one number to compare with, 10000 a major version and 100 a minor one. */
#define DAVAR_VERSION ((10000 * DAVAR_VERSION_MAJOR) + (100 * DAVAR_VERSION_MINOR) + DAVAR_VERSION_PATCH)

#endif
