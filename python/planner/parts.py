"""The optional parts of a setup, each as the C text at every place where a setup calls it."""

from dataclasses import dataclass

from . import floors
from .design import CASCADE_CLUSTERS, NUMBER, Design

SAMPLE = {"int16": "int16_t", "int32": "int32_t", "float": "float"}
SUFFIX = {type: name.lower() for type, name in NUMBER.items()}


@dataclass(frozen=True)
class Part:
    """Lines of C. In calls, `a` is the axis; {axis}, {samples} and {count} are those of a push."""

    comment: str  # and the declaration of its function, in davar_setup.h
    types: tuple[str, ...]  # headers of davar for davar_setup.h,
    includes: tuple[str, ...]  # for davar_setup.c,
    standard: tuple[str, ...]  # and those of the C library
    declarations: str
    start: str
    push: str
    gap: str
    restart: str
    function: str


def scale(design: Design) -> str:
    """The size of a count, or the range of floats: a line of an initialiser."""
    wishes = design.wishes
    if wishes.type == "float":
        return f".full_scale = {wishes.full_scale!r}, /* deg/s */"
    return f".unit_per_count = {wishes.lsb!r}, /* deg/s */"


# --- the cascade of long averaging times ---

CURVE_COMMENT = {
    "curve": """
/* Returns the long averaging times of an axis, or null until the shortest of them has a value.
 * tau[] has adev, low and high in deg/s, NaN where there is too little data. Once the curve is
 * flat, its lowest adev over 0.664 estimates the bias instability; before, that is an upper bound.
 * Call it in the main loop, as seldom as you need a curve. The result is valid until the next call
 * of take or curve. */
const davar_result_t *davar_setup_curve(uint8_t axis);
""",
    "terms": """
/* Returns the whole Allan curve of an axis, or null if nothing is known yet. tau[] has the long
 * averaging times too, and coefficient[] has the bias instability (deg/h), the rate random walk
 * (deg/h/sqrt(h)) and the other terms. It takes the newest result of the window, if there is one:
 * davar_setup_take then returns null until the next.
 * Without a new result, the short averaging times are absent (NaN), and the long ones give all
 * terms.
 * Call it in the main loop, as seldom as you need a curve: it is much slower. The result is valid
 * until the next call of take or curve. */
const davar_result_t *davar_setup_curve(uint8_t axis);
""",
}
CASCADE = """static const davar_cascade_config_t slow = {{
    .rate_hz = {rate!r},
    {scale}
    .shortest = {shortest}, /* samples */
    .tau_count = {taus},
    .clusters = {clusters},
}};
static uint64_t stages[DAVAR_SETUP_AXES][DAVAR_CASCADE_MEMORY({type}, {taus}) / 8U];
static davar_cascade_t cascade[DAVAR_SETUP_AXES];
"""
CASCADE_START = """        if ((status == DAVAR_OK) &&
            (DAVAR_CASCADE_OK !=
             davar_cascade_init_{suffix}(&cascade[a], &slow, stages[a],
                                        sizeof stages[a]))) {{
            status = DAVAR_ERR_BUILD; /* the planner checked the settings */
        }}
"""
CURVE = {
    "curve": """
const davar_result_t *davar_setup_curve(uint8_t axis)
{
    memset(&result, 0, sizeof result);
    for (uint8_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        result.coefficient[k] = (davar_coefficient_t){false, NAN, NAN, INFINITY};
    }
    if ((axis >= DAVAR_SETUP_AXES) || !davar_cascade_append(&cascade[axis], &result)) {
        return NULL;
    }
    for (uint8_t t = 0; t < result.tau_count; t++) {
        davar_adev_t *const tau = &result.tau[t];
        if (tau->differences > 0) {
            tau->edf = davar_edf_least(&result, t);
            davar_chi_square_interval(tau->edf, &tau->low, &tau->high);
            tau->low = tau->adev * sqrt(tau->low);
            tau->high = tau->adev * sqrt(tau->high);
        }
    }
    return &result;
}
""",
    "terms": """
/* A result of a window without differences. */
static void clear(void)
{
    memset(&result, 0, sizeof result);
    for (uint8_t t = 0; t < config.tau_count; t++) {
        result.tau[t].m = taus[t];
        result.tau[t].adev = NAN;
    }
    result.tau_count = config.tau_count;
}

const davar_result_t *davar_setup_curve(uint8_t axis)
{
    if (axis >= DAVAR_SETUP_AXES) {
        return NULL;
    }
    const bool has_window = davar_take(&gyro[axis], &result);
    if (!has_window) {
        clear();
    }
    const bool has_long_times = davar_cascade_append(&cascade[axis], &result);
    davar_fit(&davar_setup_plan, config.rate_hz, &result);
{flat}    return (has_window || has_long_times) ? &result : NULL;
}
""",
}
FLAT = "    (void)davar_fit_flat(&davar_setup_plan, config.rate_hz, &result);\n"


def flat(design: Design) -> str:
    """The call of the fit of the flat part after another fit, or nothing."""
    return FLAT if design.wishes.motion == "slow" else ""


def _cascade(design: Design) -> Part:
    suffix = SUFFIX[design.wishes.type]
    return Part(
        comment=CURVE_COMMENT[design.fit],
        types=(),
        includes=("cascade",),
        standard=("math", "string"),
        declarations=CASCADE.format(
            rate=design.wishes.rate_hz,
            scale=scale(design),
            shortest=design.cascade_shortest,
            taus=design.cascade_taus,
            clusters=CASCADE_CLUSTERS,
            type=NUMBER[design.wishes.type],
        ),
        start=CASCADE_START.format(suffix=suffix),
        push=f"davar_cascade_push_{suffix}(&cascade[{{axis}}], {{samples}}, {{count}});\n",
        gap="        davar_cascade_gap(&cascade[a], missing);\n",
        restart="        davar_cascade_reset(&cascade[a]);\n",
        function=CURVE[design.fit].replace("{flat}", flat(design)),
    )


# --- the floor in flight ---

FLOOR_COMMENT = """
/* Returns the newest floor of an axis since the last call, or null if there is no new one. It is
 * the noise between rotor lines and motion, in flight. It is not called angle random walk, because
 * broad vibration of the airframe is in it:
 *   high: the noise of the sensor is below it, 97.5 %, in deg/sqrt(h)
 *   value, low: the floor and its lower limit; NaN without a value
 *   why: why there is no value (davar_floor_why_text)
 * A result is due every {block} {samples}, from a window of four times as many and 32. Push
 * computes it.
 * Call it in the main loop. If a push interrupts it, it reads again until the result is consistent.
 * The result is valid until the next call for the same axis. */
const davar_floor_result_t *davar_setup_floor(uint8_t axis);
"""
FLOOR = """static const davar_floor_plan_t floor_plan = {plan};
static struct {{
{sum}    davar_floor_t window;
    davar_floor_result_t newest; /* of push */
    davar_floor_result_t taken;  /* of davar_setup_floor */
    volatile uint32_t sequence;  /* odd while push writes `newest` */
    uint32_t seen;               /* sequence of `taken` */
{clips}}} floors[DAVAR_SETUP_AXES];

static void start_floor(size_t axis)
{{
{start}    davar_floor_start(&floors[axis].window);
{delay}    floors[axis].seen = floors[axis].sequence;
}}

static void push_floor(size_t axis, const {sample} *samples, size_t count)
{{
    for (size_t i = 0; i < count; i++) {{
{push}            floors[axis].sequence = floors[axis].sequence + 1U;
            atomic_thread_fence(memory_order_release);
            davar_floor_take(&floors[axis].window, &floor_plan, &floors[axis].newest);
            atomic_thread_fence(memory_order_release);
            floors[axis].sequence = floors[axis].sequence + 1U;
        }}
    }}
}}
"""
FLOOR_PUSH = """        if (davar_floor_push(&floors[axis].window, &floor_plan, samples[i])) {
"""
FLOOR_PUSH_SUM = """        int32_t sum;
        if ((samples[i] >= {rail}) || (samples[i] <= -{rail})) {{
            floors[axis].clips = true;
        }}
        if (!davar_average_push(&floors[axis].sum, samples[i], &sum)) {{
            continue;
        }}
        if (floors[axis].clips) {{ /* a sum hides it */
            sum = INT32_MAX;
            floors[axis].clips = false;
        }}
        if (davar_floor_push(&floors[axis].window, &floor_plan, sum)) {{
"""
DELAY = """    davar_floor_delay(&floors[axis].window, (uint8_t)((axis * 32U) / DAVAR_SETUP_AXES));
"""
FLOOR_FUNCTION = """
const davar_floor_result_t *davar_setup_floor(uint8_t axis)
{
    if ((axis >= DAVAR_SETUP_AXES) || (floors[axis].sequence == floors[axis].seen)) {
        return NULL;
    }
    do {
        floors[axis].seen = floors[axis].sequence;
        atomic_thread_fence(memory_order_acquire);
        floors[axis].taken = floors[axis].newest;
        atomic_thread_fence(memory_order_acquire);
    } while (((floors[axis].seen % 2U) != 0U) || (floors[axis].seen != floors[axis].sequence));
    return &floors[axis].taken;
}
"""


def _floor(design: Design, floor: floors.Floor) -> Part:
    sums = floor.summed > 1
    init = (
        f"    davar_average_init(&floors[axis].sum, {floor.summed});\n"
        "    floors[axis].clips = false;\n"
    )
    gap = (
        "        (void)davar_average_gap(&floors[a].sum, missing);\n"
        "        floors[a].clips = false;\n"
    )
    return Part(
        comment=FLOOR_COMMENT.format(
            block=floor.block,
            samples=f"sums of {floor.summed} samples" if sums else "samples",
        ),
        types=("floor",),
        includes=("average",) * sums,
        standard=("stdatomic",),
        declarations=FLOOR.format(
            plan=floor.plan,
            sum="    davar_average_t sum;\n" * sums,
            clips="    bool clips; /* the sum has a sample at the rail */\n" * sums,
            start=init * sums,
            delay=DELAY * (design.wishes.axes > 1),
            sample=SAMPLE[design.wishes.type],
            push=FLOOR_PUSH_SUM.format(rail=floor.rail // floor.summed) if sums else FLOOR_PUSH,
        ),
        start="        start_floor(a);\n",
        push="push_floor({axis}, {samples}, {count});\n",
        gap="        davar_floor_gap(&floors[a].window);\n" + gap * sums,
        restart="        start_floor(a);\n",
        function=FLOOR_FUNCTION,
    )


def parts(design: Design) -> list[Part]:
    """The optional parts that a design has."""
    cascade = [_cascade(design)] if design.cascade_taus else []
    return cascade + ([_floor(design, design.floor)] if design.floor else [])
