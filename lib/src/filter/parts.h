/* davar - what the parts of a filter share, DESIGN (5.20). Private to the filter. */
#ifndef DAVAR_FILTER_PARTS_H
#define DAVAR_FILTER_PARTS_H

#include "davar/filter.h"

/* Makes the filter invalid for good. */
void davar_filter_forbid(davar_filter_t *filter);

/* False, and an invalid filter, if a part is out of its range, or after a sum. */
bool davar_filter_may_follow(davar_filter_t *filter, bool is_in_range);

/* Appends a part: b[0] to b[zeros], and a[0] = 1 to a[poles]; a is not read without poles. */
void davar_filter_append(davar_filter_t *filter, const double b[], uint32_t zeros, const double a[],
                         uint32_t poles);

#endif
