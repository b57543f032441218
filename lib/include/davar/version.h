/* davar - version: the one place where it is written. CMake reads this file. */
#ifndef DAVAR_VERSION_H
#define DAVAR_VERSION_H

#define DAVAR_VERSION_MAJOR 0
#define DAVAR_VERSION_MINOR 1
#define DAVAR_VERSION_PATCH 0

#endif
