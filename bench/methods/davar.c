/* davar: this library, as docs/FIRMWARE.md shows it. Windows of 600 samples, of 400 to 600 by the law
 * of Song et al. 2018, or up to 6000 by the likelihood ratio; and the floor of flight. */
#include "method.h"

#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/floor.h"
#include "davar/glr.h"

#define TAUS 7U
#define MEMORY(longest_, shortest_)                                                                \
    DAVAR_MEMORY(Q15, longest(longest_), shortest(shortest_), stride(STRIDE), largest(64),         \
                 taus(TAUS))

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};

typedef struct {
    davar_t davar;
    davar_config_t config; /* which davar keeps a pointer to */
    davar_plan_t plan;
    double rate_hz;
    double to_sigma; /* deg/s of a sample for 1 deg/sqrt(h) */
} common_t;

static davar_filter_t filter_of(const setup_t *setup)
{
    davar_filter_t filter = {.uncertainty = 0.0};
    if (setup->cutoff > 0.0) {
        davar_filter_biquad(&filter, setup->cutoff);
    }
    return filter;
}

static void begin(common_t *common, davar_config_t config, const setup_t *setup, void *memory,
                  size_t bytes)
{
    const davar_filter_t filter = filter_of(setup);
    common->rate_hz = setup->rate_hz;
    common->to_sigma = sqrt(setup->rate_hz) / 60.0;
    config.rate_hz = setup->rate_hz;
    config.unit_per_count = setup->lsb_dps;
    config.stride = STRIDE;
    config.taus = taus;
    config.tau_count = TAUS;
    if (setup->cutoff < 0.0) {
        davar_plan_init(&common->plan, taus, TAUS);
    } else {
        davar_plan_init_filtered(&common->plan, taus, TAUS, &filter);
    }
    if ((config.law == &davar_law_glr_q15) && (setup->cutoff > 0.0)) {
        davar_whiten(&config, &filter);
    }
    common->config = config;
    const davar_status_t status = davar_init_q15(&common->davar, &common->config, memory, bytes);
    if (status != DAVAR_OK) {
        fprintf(stderr, "davar: %s\n", davar_status_text(status));
        exit(1);
    }
}

/* The angle random walk of the newest result, where it is present. */
static answer_t answer(common_t *common, davar_result_t *result)
{
    const davar_coefficient_t *const arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    answer_t none = only_sigma((double)NAN);
    if (!davar_take(&common->davar, result)) {
        return none;
    }
    davar_fit(&common->plan, common->rate_hz, result);
    (void)davar_fit_flat(&common->plan, common->rate_hz, result);
    return !arw->present ? none
                         : (answer_t){arw->value * common->to_sigma, arw->low * common->to_sigma,
                                      arw->high * common->to_sigma, (double)NAN};
}

#define WINDOW(NAME, MEMORY_BYTES, SETTINGS)                                                       \
    typedef struct {                                                                               \
        common_t common;                                                                           \
        uint64_t memory[(MEMORY_BYTES) / 8U];                                                      \
    } NAME##_t;                                                                                    \
    static void NAME##_start(NAME##_t *s, const setup_t *setup)                                    \
    {                                                                                              \
        begin(&s->common, (davar_config_t){SETTINGS}, setup, s->memory, sizeof s->memory);         \
    }                                                                                              \
    static void NAME##_push(NAME##_t *s, int16_t x)                                                \
    {                                                                                              \
        davar_push_q15(&s->common.davar, &x, 1U);                                                  \
    }                                                                                              \
    static void NAME##_gap(NAME##_t *s, uint32_t missing)                                          \
    {                                                                                              \
        davar_gap(&s->common.davar, missing);                                                      \
    }

WINDOW(fixed, MEMORY(600, 600), DAVAR_FIXED(600))
static answer_t fixed_take(fixed_t *s)
{
    davar_result_t result;
    return answer(&s->common, &result);
}
METHOD(fixed)

WINDOW(song, MEMORY(600, 400), DAVAR_SONG(600, 400))
static answer_t song_take(song_t *s)
{
    davar_result_t result;
    return answer(&s->common, &result);
}
METHOD(song)

#define BLOCKS 600U
WINDOW(glr, DAVAR_MEMORY_GLR(Q15, longest(10U * BLOCKS), largest(64), taus(TAUS)),
       DAVAR_GLR_Q15(BLOCKS))
static answer_t glr_take(glr_t *s)
{
    davar_result_t result;
    davar_glr_report_t report;
    answer_t found = answer(&s->common, &result);
    davar_glr_report(&s->common.davar, &report);
    found.alarm = report.alarm ? 1.0 : 0.0;
    return found;
}
METHOD(glr)

typedef struct {
    davar_floor_t floor;
    davar_floor_plan_t plan;
    davar_floor_result_t newest;
    double to_sigma;
    bool unknown;
} floor_t;
static void floor_start(floor_t *s, const setup_t *setup)
{
    const davar_filter_t filter = filter_of(setup);
    const davar_floor_config_t config = {.rate_hz = setup->rate_hz,
                                         .unit_per_count = setup->lsb_dps,
                                         .rail = INT16_MAX,
                                         .filter = &filter};
    s->unknown = setup->cutoff < 0.0; /* must not be used then */
    s->to_sigma = sqrt(setup->rate_hz) / 60.0;
    s->newest.why = DAVAR_FLOOR_FILLING;
    (void)davar_floor_plan(&s->plan, &config);
    davar_floor_start(&s->floor);
}
static void floor_push(floor_t *s, int16_t x)
{
    if (davar_floor_push(&s->floor, &s->plan, x)) {
        davar_floor_take(&s->floor, &s->plan, &s->newest);
    }
}
static void floor_gap(floor_t *s, uint32_t missing)
{
    (void)missing;
    davar_floor_gap(&s->floor);
}
static answer_t floor_take(const floor_t *s)
{
    if (s->unknown || (s->newest.why != DAVAR_FLOOR_VALUE)) {
        return only_sigma((double)NAN);
    }
    return (answer_t){(double)s->newest.value * s->to_sigma, (double)s->newest.low * s->to_sigma,
                      (double)s->newest.high * s->to_sigma, (double)NAN};
}
METHOD(floor)

PROGRAM({"davar fixed", sizeof(fixed_t), fixed_run}, {"davar or", sizeof(song_t), song_run},
        {"davar glr", sizeof(glr_t), glr_run}, {"davar floor", sizeof(floor_t), floor_run})
