/* davar tests - the filters of the statistics suites. */
#ifndef DAVAR_TESTS_FILTER_CASES_H
#define DAVAR_TESTS_FILTER_CASES_H

#include "shape.h"

typedef struct {
    const char *name;
    shape_t filter;
} case_t;

static const case_t cases[] = {
    {"white", {.poles = 0U}},
    {"1 pole 0.05", {.cutoff = 0.05, .poles = 1U}},
    {"1 pole 0.25", {.cutoff = 0.25, .poles = 1U}},
    {"2 poles 0.05", {.cutoff = 0.05, .poles = 2U}},
    {"2 poles 0.1", {.cutoff = 0.1, .poles = 2U}},
    {"2 poles 0.25", {.cutoff = 0.25, .poles = 2U}},
    {"2 poles 0.45", {.cutoff = 0.45, .poles = 2U}},
    {"CIC 3:4", {.averages = 3U, .length = 4U, .decimation = 4U}},
    {"average of 2", {.averages = 1U, .length = 2U}},
    {"average of 8", {.averages = 1U, .length = 8U}},
};
#define CASES (sizeof cases / sizeof cases[0])
#define WHITE_CASE 0U
#define NARROW_CASE 3U
#define LESS_NARROW_CASE 4U

#endif
