/* davar-sim - converts option values from text to numbers. An error message names the option. */
#ifndef VALUE_H
#define VALUE_H

#include "common/sim_error.h"

#include <stddef.h>
#include <stdint.h>

/* A whole number, 0 .. 2^32 - 1, digits only. */
bool value_u32(const char *option, const char *text, uint32_t *value, sim_error_t *error);

/* A comma-separated list of whole numbers. False also if it is longer than `capacity`. */
bool value_u32_list(const char *option, const char *text, uint32_t *values, size_t capacity,
                    size_t *count, sim_error_t *error);

/* A finite number above zero. */
bool value_positive(const char *option, const char *text, double *value, sim_error_t *error);

/* Two finite numbers LOW:HIGH, 0 <= LOW <= HIGH. */
bool value_range(const char *option, const char *text, double *low, double *high,
                 sim_error_t *error);

/* Position of text in a list of `count` words. */
bool value_choice(const char *option, const char *text, const char *const *words, size_t count,
                  size_t *choice, sim_error_t *error);

#endif
