/** @file
 * davar - version. The number is written here only; CMake reads this file. */
#ifndef DAVAR_VERSION_H
#define DAVAR_VERSION_H

/** Raised by incompatible changes. */
#define DAVAR_VERSION_MAJOR 0
/** Raised by additions; before 1.0 by incompatible changes too. */
#define DAVAR_VERSION_MINOR 1
/** Raised by fixes. */
#define DAVAR_VERSION_PATCH 0

/** The version as one number for comparisons: 10000 major + 100 minor + patch. */
#define DAVAR_VERSION                                                                              \
    ((10000 * DAVAR_VERSION_MAJOR) + (100 * DAVAR_VERSION_MINOR) + DAVAR_VERSION_PATCH)

#endif
