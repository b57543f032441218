/* davar programs - the text of a filter. */
#include "setup/bandwidth.h"
#include "davar/filter.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* One part of the text, and the rate at its place. */
typedef struct {
    const char *at; /* what is not yet read; null after an error */
    const char *end;
    double rate_hz; /* 0: only the form counts */
    davar_filter_t *filter;
} part_t;

/* --- what a part consists of --- */

static void expect(part_t *part, bool good)
{
    part->at = good ? part->at : NULL;
}

/* Skips `c`. False: something else is there. */
static bool skip(part_t *part, char c)
{
    const bool is_there = (part->at != NULL) && (part->at < part->end) && (*part->at == c);
    if (is_there) {
        part->at++;
    }
    return is_there;
}

static double read_number(part_t *part, double least, double most)
{
    char *end = NULL;
    if (part->at == NULL) {
        return 0.0;
    }
    const double value = strtod(part->at, &end);
    const bool good = (end != part->at) && (end <= part->end) && (value >= least) &&
                      (value <= most); /* not NaN */
    part->at = good ? end : NULL;
    return good ? value : 0.0;
}

static unsigned read_count(part_t *part, unsigned most)
{
    const double value = read_number(part, 1.0, (double)most);
    expect(part, (part->at != NULL) && (floor(value) >= value));
    return (unsigned)value;
}

/* ":PERCENT" at the end of a part, or `usual`. Returns a share. */
static double read_percent(part_t *part, double usual)
{
    return 0.01 * (skip(part, ':') ? read_number(part, 0.0, 50.0) : usual);
}

static void set_largest(double *share, double other)
{
    *share = fmax(*share, other);
}

/* A frequency over the rate. */
static double read_hz(part_t *part)
{
    const double hz = read_number(part, 0.0, HUGE_VAL);
    expect(part, (hz > 0.0) && isfinite(hz));
    return (part->rate_hz > 0.0) ? (hz / part->rate_hz) : 0.1;
}

/* --- the parts --- */

static void read_low_pass(part_t *part)
{
    const double cutoff = read_hz(part);
    const unsigned order = skip(part, ':') ? read_count(part, 2U) : 2U;
    davar_filter_low_pass(part->filter, cutoff, order, read_percent(part, 10.0));
}

static void read_biquad(part_t *part)
{
    davar_filter_biquad(part->filter, read_hz(part));
    set_largest(&part->filter->uncertainty, read_percent(part, 0.0));
}

static void read_pt1(part_t *part)
{
    davar_filter_pt1(part->filter, read_hz(part));
    set_largest(&part->filter->uncertainty, read_percent(part, 0.0));
}

static void read_notch(part_t *part)
{
    const double centre = read_hz(part);
    expect(part, skip(part, ':'));
    davar_filter_notch(part->filter, centre, read_number(part, 0.1, 100.0));
    set_largest(&part->filter->uncertainty, read_percent(part, 0.0));
}

/* [ORDER]:N, of which the colon is already skipped if there is no order. */
static unsigned read_order(part_t *part)
{
    const bool has_order = (part->at[-1] != ':');
    const unsigned order = has_order ? read_count(part, 8U) : 1U;
    expect(part, !has_order || skip(part, ':'));
    return order;
}

static void read_average(part_t *part)
{
    const unsigned order = read_order(part);
    davar_filter_average(part->filter, order, read_count(part, DAVAR_FILTER_SPAN));
}

static void read_cic(part_t *part)
{
    const unsigned order = read_order(part);
    davar_filter_cic(part->filter, order, read_count(part, 4096U));
}

static void read_sum(part_t *part)
{
    davar_filter_sum(part->filter, read_count(part, 4096U));
}

static unsigned read_list(part_t *part, double values[], unsigned most)
{
    unsigned count = 0U;
    do {
        expect(part, count < most);
        values[(count < most) ? count : 0U] = read_number(part, -1e9, 1e9);
        count++;
    } while (skip(part, ','));
    return count;
}

static void read_ba(part_t *part)
{
    double b[DAVAR_FILTER_ZEROS + 1U] = {0.0};
    double a[DAVAR_FILTER_POLES + 1U] = {1.0};
    const unsigned zeros = read_list(part, b, DAVAR_FILTER_ZEROS + 1U);
    const unsigned poles = skip(part, ':') ? read_list(part, &a[1], DAVAR_FILTER_POLES) : 0U;
    if (part->at != NULL) {
        davar_filter_ba(part->filter, b, zeros, a, poles + 1U);
        set_largest(&part->filter->level, read_percent(part, 0.0));
    }
}

/* The name with the colon after it, or a name before [ORDER]:; the low-pass has none. */
static const struct {
    const char *name;
    void (*read)(part_t *part);
    bool has_hz;
    const char *expected;
} PARTS[] = {
    {"biquad:", read_biquad, true,
     "biquad:HZ[:PERCENT] with HZ from 0.002 to below 0.5 times the sample rate there"},
    {"pt1:", read_pt1, true,
     "pt1:HZ[:PERCENT] with HZ from 0.002 to 4 times the sample rate there"},
    {"notch:", read_notch, true,
     "notch:HZ:Q[:PERCENT] with HZ below half the sample rate there, Q from 0.1 to 100 and a "
     "memory of "
     "up to 1024 samples, as a smaller Q has it"},
    {"average:", read_average, false, "average:N with N to 1024"},
    {"average", read_average, false, "average[ORDER]:N with ORDER to 8 and ORDER times N to 1024"},
    {"cic:", read_cic, false, "cic:N with N to 4096"},
    {"cic", read_cic, false, "cic[ORDER]:N with ORDER to 8 and N to 4096"},
    {"sum:", read_sum, false, "sum:N with N to 4096, as the last part"},
    {"ba:", read_ba, false,
     "ba:B0,B1,..[:A1,A2,..[:PERCENT]] without A0, which is 1; 1 to 32 B whose sum is not 0, and "
     "up to 8 A that are stable and forget a sample within 1024"},
    {"", read_low_pass, true,
     "HZ[:ORDER[:PERCENT]] as the first part, with HZ from 0.002 to 4 times the sample rate there, "
     "order 1 or 2, at most 50 percent"},
};
#define COUNT (sizeof PARTS / sizeof PARTS[0])

static const char SERIES[] =
    "a series of up to 8 poles and 31 zeros with a memory of "
    "up to 1024 samples, an analogue low-pass only as its first part and sum:N as its "
    "last";

static const char FORMS[] =
    "parts with + between them: HZ[:ORDER[:PERCENT]], biquad:HZ, pt1:HZ, notch:HZ:Q, "
    "average[ORDER]:N, cic[ORDER]:N, sum:N, ba:B0,B1,..[:A1,A2,..]; or none";

/* --- the text --- */

/* The end of a part: its +, which is not the sign of a number or of an exponent. */
static const char *end_of(const char *text)
{
    const char *at = text;
    while ((*at != '\0') && ((*at != '+') || ((at > text) && (strchr(",:eE", at[-1]) != NULL)))) {
        at++;
    }
    return at;
}

/* The form of the part at `text`; COUNT: none. */
static size_t form_of(const char *text)
{
    size_t i = 0U;
    while ((i < COUNT) && (strncmp(text, PARTS[i].name, strlen(PARTS[i].name)) != 0)) {
        i++;
    }
    const bool begins_a_number = ((*text >= '0') && (*text <= '9')) || (*text == '.');
    return ((i + 1U == COUNT) && !begins_a_number) ? COUNT : i;
}

/* Why a part cannot be added: its own form, or the series. */
static const char *reason(part_t part, size_t form)
{
    davar_filter_t alone = {.length = 0U};
    part.filter = &alone;
    PARTS[form].read(&part);
    return ((part.at == part.end) && davar_filter_is_valid(&alone)) ? SERIES : PARTS[form].expected;
}

/* By what the parts from `text` on divide the rate. */
static double division_of(const char *text)
{
    double division = 1.0;
    for (const char *at = text; *at != '\0'; at += (*at == '+') ? 1 : 0) {
        const char *const end = end_of(at);
        const char *const colon = strchr(at, ':');
        if (((strncmp(at, "cic", 3U) == 0) || (strncmp(at, "sum", 3U) == 0)) && (colon != NULL) &&
            (colon < end)) {
            division *= fmax(strtod(colon + 1, NULL), 1.0);
        }
        at = end;
    }
    return division;
}

const char *bandwidth_read(const char *text, double rate_hz, davar_filter_t *filter)
{
    memset(filter, 0, sizeof *filter);
    if (strcmp(text, "none") == 0) {
        return NULL;
    }
    for (const char *at = text;; at++) {
        const size_t form = form_of(at);
        if (form == COUNT) {
            return FORMS;
        }
        part_t part = {.at = at + strlen(PARTS[form].name), .end = end_of(at), .filter = filter};
        at = part.end;
        part.rate_hz = rate_hz * division_of(at + ((*at == '+') ? 1 : 0));
        const part_t begin = part;
        PARTS[form].read(&part);
        if ((part.at != part.end) || ((rate_hz > 0.0) && !davar_filter_is_valid(filter))) {
            return reason(begin, form);
        }
        if (*at == '\0') {
            return NULL;
        }
    }
}

bool bandwidth_has_hz(const char *text)
{
    for (const char *at = text; strcmp(text, "none") != 0; at++) {
        const size_t form = form_of(at);
        if ((form < COUNT) && PARTS[form].has_hz) {
            return true;
        }
        at = end_of(at);
        if (*at == '\0') {
            break;
        }
    }
    return false;
}
