/* davar tests - what a setup of tools/davar-plan costs on this target: instructions (exact under
 * -icount) and bytes of stack. One line "name value" per figure; tools/support/setup_cost.py reads
 * them. SAMPLE: type of a sample. UNIT: size of a sample's noise over 120. WINDOW, STRIDE: of the
 * setup. FLOOR: samples between the floors of an axis. Without MEASURED: the smallest program with the setup, to measure what it links, or with
 * EMPTY without it. */
#ifndef EMPTY
#include "davar_setup.h"
#endif

#ifdef MEASURED

#include "measuring.h"

#ifndef FLOOR
#define FLOOR 0U
#endif
#define FILL ((2U * WINDOW) + (5U * FLOOR)) /* samples, after which every window is full */
#define STACK_WORDS 832U
#include "stack_paint.h"

static SAMPLE samples[DAVAR_SETUP_AXES];
static const davar_result_t *volatile taken;
static uint32_t pushed;  /* samples so far */
static uint32_t nothing; /* instructions of a measurement itself */

/* The same on all axes, so that everything that can happen in one push does. */
static void next_samples(int32_t times)
{
    const int32_t value = times * ((noise_of(12U) / 2) + 20); /* sigma 120 */
    for (unsigned a = 0U; a < DAVAR_SETUP_AXES; a++) {
        samples[a] = (SAMPLE)value * (SAMPLE)UNIT;
    }
}

static uint32_t push(void)
{
    pushed++;
    const uint32_t mark = board_mark();
    davar_setup_push(samples, 1U);
    return board_instructions_since(mark) - nothing;
}

/* Gets the results of all axes. Returns the instructions for each, 0 if one has no result. */
static uint32_t spent_in(const davar_result_t *(*get)(uint8_t axis))
{
    const uint32_t mark = board_mark();
    uint32_t results = 0U;
    for (uint8_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
        taken = get(a);
        results += (taken != NULL) ? 1U : 0U;
    }
    const uint32_t spent = board_instructions_since(mark);
    return (results == DAVAR_SETUP_AXES) ? (spent / results) : 0U;
}

/* White noise, every result taken. */
static void measure_quiet(void)
{
    uint64_t pushes = 0U;
    uint64_t takes = 0U;
    uint32_t results = 0U;
    const uint32_t count = STRIDE * (((2000U + (16U * FLOOR)) / STRIDE) + 8U);
    for (uint32_t i = 0U; i < FILL; i++) {
        next_samples(1);
        (void)push();
        (void)spent_in(davar_setup_take);
    }
    for (uint32_t i = 0U; i < count; i++) {
        next_samples(1);
        pushes += push();
        const uint32_t spent = spent_in(davar_setup_take);
        takes += spent;
        results += (spent > 0U) ? 1U : 0U;
    }
    board_figure("mean_push_x100", (uint32_t)((100U * pushes) / count));
    board_figure("mean_take", (uint32_t)(takes / ((results > 0U) ? results : 1U)));
}

/* First the noise grows every PERIOD samples, just after a gap, so that law glr accepts three blocks
 * at once. A result is due 10 to 60 samples later. Then there are shocks, and a gap in every fourth stride, just
 * before a result is due or a few samples earlier, so that both edges of a fixed window of eight
 * strides meet one at the same time. */
#define PERIOD (STRIDE * ((1400U + STRIDE - 1U) / STRIDE))
#define CHANGES (12U * PERIOD)
#define REGULAR ((40U * STRIDE) + 4000U)

static bool is_gap(uint32_t i, uint32_t phase)
{
    const uint32_t stride = i / STRIDE;
    const uint32_t place = STRIDE - 1U - ((stride / 16U) % 4U);
    const bool regular = ((stride % 4U) == 0U) && ((i % STRIDE) == place);
    return (i < CHANGES) ? (phase == 0U) : regular;
}

/* Noise that falls with frequency, so that a floor sorts the most. Returns the worst push. */
static uint32_t worst_of_floor(void)
{
    int32_t once = 0;
    int32_t twice = 0;
    int32_t thrice = 0;
    uint32_t worst = 0U;
    for (uint32_t i = 0U; i < (12U * FLOOR); i++) {
        once += ((noise_of(12U) / 2) + 20) - (once / 16);
        twice += (once - twice) / 16;
        thrice += (twice - thrice) / 8;
        for (unsigned a = 0U; a < DAVAR_SETUP_AXES; a++) {
            samples[a] = (SAMPLE)thrice * (SAMPLE)UNIT;
        }
        worst = larger(worst, push());
        (void)spent_in(davar_setup_take);
    }
    return worst;
}

/* Noise that is at times five times as large, with shocks and gaps. */
static void measure_rough(void)
{
    uint32_t worst = worst_of_floor();
    uint32_t worst_take = 0U;
    for (uint32_t i = 0U; i < (CHANGES + REGULAR); i++) {
        const uint32_t phase = (pushed + 10U + (10U * ((i / PERIOD) % 6U))) % PERIOD;
        const bool shock = (i >= CHANGES) && ((i % 450U) < 8U);
        next_samples(shock ? 40 : ((phase < (PERIOD / 2U)) ? 5 : 1));
        if (is_gap(i, phase)) {
            davar_setup_gap(1U);
        }
        worst = larger(worst, push());
        worst_take = larger(worst_take, spent_in(davar_setup_take));
    }
    board_figure("worst_push", worst);
    board_figure("worst_take", worst_take);
#ifdef CURVE
    uint32_t of_curve = 0U;
    for (uint32_t i = 0U; i < (4U * STRIDE); i++) {
        next_samples(1);
        (void)push();
        of_curve = larger(of_curve, spent_in(davar_setup_curve));
    }
    board_figure("curve", of_curve);
#endif
}

/* A motion that every part of the fit of the flat part meets: samples of a slow triangle. */
static void next_moving(uint32_t i)
{
    const int32_t half = (int32_t)(WINDOW / 2U);
    const int32_t place = (int32_t)(i % WINDOW) - half;
    const int32_t height = half - ((place < 0) ? -place : place);
    next_samples(1);
    for (unsigned a = 0U; a < DAVAR_SETUP_AXES; a++) {
        samples[a] += (SAMPLE)(10 * height) * (SAMPLE)UNIT;
    }
}

static void measure_moving(void)
{
    uint32_t worst = 0U;
    for (uint32_t i = 0U; i < (3U * WINDOW); i++) {
        next_moving(i);
        (void)push();
        worst = larger(worst, spent_in(davar_setup_take));
    }
    board_figure("moving_take", worst);
}

static void take_all(void)
{
    for (uint8_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
#ifdef CURVE
        taken = davar_setup_curve(a);
#endif
        taken = davar_setup_take(a);
    }
}

static void measure_stack(void)
{
    uint32_t of_push = 0U;
    uint32_t of_take = 0U;
    for (uint32_t i = 0U; i < ((4U * WINDOW) + (STRIDE * 4U) + (2U * FLOOR)); i++) {
        const uintptr_t from = stack_pointer();
        if (i < (2U * WINDOW)) {
            next_moving(i);
        } else {
            next_samples((((i / 300U) % 2U) == 0U) ? 1 : 20);
        }
        paint(from);
        if (i == 100U) {
            davar_setup_gap(1U);
        }
        davar_setup_push(samples, 1U);
        of_push = larger(of_push, used(from));
        if ((i % STRIDE) == (STRIDE - 1U)) {
            paint(from);
            take_all();
            of_take = larger(of_take, used(from));
        }
    }
    board_figure("stack_push", of_push);
    board_figure("stack_take", of_take);
}

int main(void)
{
    const uintptr_t from = stack_pointer();
    paint(from);
    const davar_status_t status = davar_setup_start();
    board_figure("stack_start", used(from));
    if (status != DAVAR_OK) {
        board_figure("refused_with_status", (uint32_t)status);
        board_exit(1);
    }
    nothing = instructions_of_nothing();
    measure_quiet();
    measure_rough();
    measure_moving();
    measure_stack();
    return 0;
}

#else

#include <stdint.h>

static volatile struct {
    SAMPLE input;
    double output;
    const void *floor;
} port; /* of one size, whatever a setup adds */

int main(void);
void _exit(int status);

int main(void)
{
#ifndef EMPTY
    SAMPLE samples[DAVAR_SETUP_AXES];
    if (davar_setup_start() != DAVAR_OK) {
        return 1;
    }
    for (;;) {
        for (uint8_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
            samples[a] = port.input;
        }
        davar_setup_push(samples, 1U);
        for (uint8_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
            const davar_result_t *result = davar_setup_take(a);
#ifdef CURVE
            result = (result == (void *)0) ? davar_setup_curve(a) : result;
#endif
#ifdef FLOOR
            port.floor = davar_setup_floor(a);
#endif
            if (result != (void *)0) {
                port.output = result->coefficient[DAVAR_ANGLE_RANDOM_WALK].value;
            }
        }
    }
#else
    for (;;) {
        port.output = (double)(int)port.input;
    }
#endif
}

void _exit(int status)
{
    (void)status;
    for (;;) {
    }
}

#endif
