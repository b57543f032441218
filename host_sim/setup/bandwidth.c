/* davar programs - the text of a filter. */
#include "setup/bandwidth.h"
#include "davar/filter.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Reads a whole number from 1 to most at *text and moves on. */
static bool read_count(const char **text, uint32_t most, uint32_t *count)
{
    uint32_t value = 0U;
    const char *digit = *text;
    while ((*digit >= '0') && (*digit <= '9') && (value <= most)) {
        value = (10U * value) + (uint32_t)(*digit - '0');
        digit++;
    }
    const bool good = (digit != *text) && (value >= 1U) && (value <= most);
    *text = digit;
    *count = value;
    return good;
}

/* Reads the moving averages at *text and moves on. */
static bool read_averages(const char **text, davar_filter_t *filter)
{
    uint32_t order = 1U;
    uint32_t length = 0U;
    const bool is_sum = strncmp(*text, "sum", 3U) == 0;
    const bool is_average = strncmp(*text, "average", 7U) == 0;
    *text += is_average ? 7U : 3U;
    bool good = is_sum || (**text == ':') || read_count(text, 8U, &order);
    good = good && (**text == ':');
    *text += good ? 1U : 0U;
    good = good && read_count(text, 4096U, &length);
    good = good && (!is_average || ((order * length) <= DAVAR_FILTER_SPAN_MOST));
    filter->averages = (uint8_t)order;
    filter->length = (uint16_t)length;
    filter->decimation = (uint16_t)(is_average ? 1U : length);
    filter->summed = (uint16_t)(is_sum ? length : 1U);
    return good;
}

/* Reads the low-pass at *text and moves on. */
static bool read_low_pass(const char **text, bandwidth_t *bandwidth)
{
    char *end = NULL;
    uint32_t order = 2U;
    double percent = 10.0;
    bandwidth->hz = strtod(*text, &end);
    bool good = (end != *text) && isfinite(bandwidth->hz) && (bandwidth->hz > 0.0);
    *text = end;
    if (good && (**text == ':')) {
        (*text)++;
        good = read_count(text, 2U, &order);
        if (good && (**text == ':')) {
            const char *const begin = *text + 1;
            percent = strtod(begin, &end);
            good = (end != begin) && (percent >= 0.0) && (percent <= 50.0);
            *text = end;
        }
    }
    bandwidth->filter.poles = (uint8_t)order;
    bandwidth->filter.uncertainty = 0.01 * percent;
    return good;
}

bool bandwidth_read(const char *text, bandwidth_t *bandwidth)
{
    *bandwidth = (bandwidth_t){.hz = 0.0};
    if (strcmp(text, "none") == 0) {
        return true;
    }
    bool good = true;
    if ((*text >= '0') && (*text <= '9')) {
        good = read_low_pass(&text, bandwidth);
        if (!good || (*text == '\0')) {
            return good;
        }
        good = (*text == '+');
        text++;
    }
    good = good &&
           ((strncmp(text, "cic", 3U) == 0) || (strncmp(text, "sum", 3U) == 0) ||
            (strncmp(text, "average", 7U) == 0)) &&
           read_averages(&text, &bandwidth->filter);
    return good && (*text == '\0');
}

bool bandwidth_at(const bandwidth_t *bandwidth, double rate_hz, davar_filter_t *filter)
{
    *filter = bandwidth->filter;
    filter->cutoff = bandwidth->hz / rate_hz;
    const double decimation = (filter->decimation > 1U) ? (double)filter->decimation : 1.0;
    return (filter->poles == 0U) ||
           ((filter->cutoff >= 0.002) && (filter->cutoff <= (2.0 * decimation)));
}
