/* davar - marks parts of a result as absent. */
#include "number/absent.h"

#include <math.h>

void davar_absent_taus(davar_result_t *result, uint32_t from)
{
    for (uint32_t t = from; t < result->tau_count; t++) {
        result->tau[t].edf = (double)NAN;
        result->tau[t].low = (double)NAN;
        result->tau[t].high = (double)NAN;
    }
}

void davar_absent_coefficients(davar_result_t *result)
{
    result->noise = DAVAR_NOISE_UNKNOWN;
    result->flat_from = 0U;
    result->flat_to = 0U;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        davar_coefficient_t *const coefficient = &result->coefficient[k];
        coefficient->present = false;
        coefficient->value = (double)NAN;
        coefficient->low = (double)NAN;
        coefficient->high = (double)INFINITY;
    }
}
