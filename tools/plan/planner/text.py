"""The C text of a design: davar_setup.h, davar_setup.c and the options of the build."""

from collections.abc import Sequence

from . import programs
from .design import BLOCK, CASCADE_CLUSTERS, NUMBER, Design

SUFFIX = {type: name.lower() for type, name in NUMBER.items()}
SAMPLE = {"int16": "int16_t", "int32": "int32_t", "float": "float"}
TOGETHER = 16  # samples of an axis that a push hands on at once


def defines(design: Design) -> list[str]:
    """The -D options of the build."""
    narrow = design.wishes.type == "int16"
    options = {
        "TAUS_MAX": design.taus_max,
        "Q31" if narrow else "Q15": 0,
        "LAWS": int(design.law == "glr"),
    }
    return [f"DAVAR_{name}={value}" for name, value in options.items()]


def _scale(design: Design) -> str:
    wishes = design.wishes
    if wishes.type == "float":
        return f".full_scale = {wishes.full_scale!r}, /* deg/s */"
    return f".unit_per_count = {wishes.lsb!r}, /* deg/s */"


def _window(design: Design, whitening: Sequence[str]) -> list[str]:
    if design.law == "fixed":
        window = f".window = {{.longest = {design.window}, .shortest = {design.window}"
        return [f"{window}, .gaps_max = {design.gaps}}}, /* samples */"]
    wishes = design.wishes
    law = SUFFIX["int16" if wishes.type == "int16" else "int32"]
    return [
        f".law = &davar_law_glr_{law},",
        f".window = {{.longest = {design.window}, .shortest = {design.shortest}, .grow = 1,",
        f"           .shrink = 64, .gaps_max = {design.gaps}}},",
        f".glr = {{.false_alarms_per_hour = {wishes.false_alarms_per_hour!r},",
        f"        .cut_interval_s = 300.0, .block = {BLOCK}, .shock_blocks = 2"
        + ("," if whitening else "},"),
        *(f"        {line}" for line in whitening[:-1]),
        *(f"        {line}}}," for line in whitening[-1:]),
    ]


def _engine(design: Design) -> str:
    if (design.engine, design.law) != ("grid", "fixed"):
        return ""
    number = "q15" if design.wishes.type == "int16" else "q31"
    return f"\n    .engine = &davar_engine_grid_{number},"


def _memory(design: Design) -> str:
    of_law, _, number = design.memory[0].rpartition("_")
    window, stride, largest, taus = design.memory[1]
    settings = {"longest": window, "shortest": window, "stride": stride, "largest": largest}
    if design.law == "glr":
        del settings["shortest"], settings["stride"]
    named = ", ".join(f"{name}({value})" for name, value in {**settings, "taus": taus}.items())
    macro = f"DAVAR_MEMORY{'_' * bool(of_law)}{of_law}({number}, {named})"
    return f"({macro} + {design.gap_bytes}U)"


HEADER = """/* {title}
{about}
 */
#ifndef DAVAR_SETUP_H
#define DAVAR_SETUP_H

{davar}

#if {conditions}
#error "{wrong}"
#endif

#ifdef __cplusplus
extern "C" {{
#endif

#define DAVAR_SETUP_AXES {axes}
#define DAVAR_SETUP_RATE_HZ {rate!r}

/* Starts all axes. Call it once, before the interrupt is enabled. Returns DAVAR_OK, or an error:
 * then call no other function of this file. */
DAVAR_NODISCARD davar_status_t davar_setup_start(void);

/* Pushes `count` samples of {each}
 * Call it from the interrupt, with blocks of any size. It never waits. */
void davar_setup_push(const {sample} *samples, size_t count);

/* Reports that `missing` samples of each axis were lost before the next push. Call it from the
 * interrupt. */
void davar_setup_gap(uint32_t missing);

/* Returns the newest result of an axis, 0 to {last}, or null if there is no new one.
 * Call it in the main loop. The result is valid until the next call{also}, for any
 * axis:
 *   coefficient[DAVAR_ANGLE_RANDOM_WALK]: present, value, low, high, in deg/sqrt(h)
 *   noise: why a coefficient is absent{more} */
const davar_result_t *davar_setup_take(uint8_t axis);
{curve}
/* Returns to the state after davar_setup_start, counters included. Call it while no push is at
 * work, for example after the gyro was configured again. */
void davar_setup_restart(void);

/* Returns the counts of gaps, lost and clipped samples, missed results and alarms of an axis since
 * the start; all are 0 if there is no such axis. Call it in the main loop. davar_can_health copies
 * them to the counters of CAN and serial frames. */
davar_health_t davar_setup_health(uint8_t axis);

/* Returns the instance of an axis, or null if there is no such axis. Other functions of davar need
 * it. A result that davar_take takes from it is missing in davar_setup_take. */
davar_t *davar_setup_instance(uint8_t axis);

/* Returns the configuration of all instances: rate, stride, window and cluster sizes. The encoder
 * of frames needs it (davar_encoder_init). */
const davar_config_t *davar_setup_config(void);

#ifdef __cplusplus
}}
#endif

#endif
"""


CURVE_COMMENT = {
    "arw": "",
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


def header(design: Design, title: str, about: Sequence[str], alone: bool) -> str:
    """davar_setup.h. about: lines for the comment at the top; alone: see files()."""
    axes = design.wishes.axes
    unit = "deg/s" if design.wishes.type == "float" else "counts"
    each = (
        f"the gyro, in {unit}."
        if axes == 1
        else f"each of the {axes} axes, in {unit}, in this order:\n"
        f" * the first sample of every axis, then the second of every axis, and so on."
    )
    checks = [f"({name} != {value})" for name, value in (d.split("=") for d in defines(design))]
    lines = [" || ".join(checks[i : i + 3]) for i in range(0, len(checks), 3)]
    glr = ("glr",) if design.law == "glr" else ()
    more = ""
    if glr:
        more += (
            "\n * Then davar_glr_report(davar_setup_instance(axis), &report) sets report.alarm"
            "\n * if the noise has changed since the previous report."
        )
    return HEADER.format(
        title=title,
        about="\n".join(f" * {line}".rstrip() for line in about),
        davar='#include "davar.h"'
        if alone
        else "\n".join(f'#include "davar/{name}.h"' for name in ("davar", "fit", *glr)),
        conditions=" || \\\n    ".join(lines),
        wrong="this is another davar.h, or -DDAVAR_ options contradict it"
        if alone
        else "compile davar and everything that includes its headers with the options of "
        "davar_setup.args",
        axes=axes,
        rate=design.wishes.rate_hz,
        each=each,
        sample=SAMPLE[design.wishes.type],
        last=axes - 1,
        more=more,
        also=" of take or curve" if design.cascade_taus else "",
        curve=CURVE_COMMENT[design.fit],
    )


SOURCE = """/* {title} davar_setup.h describes it. */
#include "davar_setup.h"
{includes}
{plan}
static const uint32_t taus[] = {{{taus}}}; /* samples */
static const davar_config_t config = {{
    .rate_hz = {rate!r},
    {scale}
    .stride = {stride},{engine}
    {window}
    .taus = taus,
    .tau_count = {count},
}};
static uint64_t memory[DAVAR_SETUP_AXES]
                      [{memory} / 8U];
static davar_t gyro[DAVAR_SETUP_AXES];
{cascade}
davar_status_t davar_setup_start(void)
{{
    for (size_t a = 0; a < DAVAR_SETUP_AXES; a++) {{
        davar_status_t status =
            davar_init_{suffix}(&gyro[a], &config, memory[a], sizeof memory[a]);
{start}        if (status != DAVAR_OK) {{
            return status;
        }}
    }}
    return DAVAR_OK;
}}

{push}
void davar_setup_gap(uint32_t missing)
{{
    for (size_t a = 0; a < DAVAR_SETUP_AXES; a++) {{
        davar_gap(&gyro[a], missing);
{gap}    }}
}}

static davar_result_t result;

const davar_result_t *davar_setup_take(uint8_t axis)
{{
    if ((axis >= DAVAR_SETUP_AXES) || !davar_take(&gyro[axis], &result)) {{
        return NULL;
    }}
    (void){white}(&davar_setup_plan, config.rate_hz, &result);
{flat}    return &result;
}}
{curve}
void davar_setup_restart(void)
{{
    for (size_t a = 0; a < DAVAR_SETUP_AXES; a++) {{
        davar_reset(&gyro[a]);
{restart}    }}
}}

davar_health_t davar_setup_health(uint8_t axis)
{{
    const davar_health_t none = {{0}};
    return (axis < DAVAR_SETUP_AXES) ? davar_health(&gyro[axis]) : none;
}}

davar_t *davar_setup_instance(uint8_t axis)
{{
    return (axis < DAVAR_SETUP_AXES) ? &gyro[axis] : NULL;
}}

const davar_config_t *davar_setup_config(void)
{{
    return &config;
}}
"""

PUSH_ONE = """void davar_setup_push(const {sample} *samples, size_t count)
{{
    davar_push_{suffix}(&gyro[0], samples, count);
{cascade}}}
"""

PUSH_ALL = """void davar_setup_push(const {sample} *samples, size_t count)
{{
    {sample} one[{together}]; /* samples of one axis */
    while (count > 0) {{
        const size_t n = (count < {together}) ? count : {together};
        for (size_t a = 0; a < DAVAR_SETUP_AXES; a++) {{
            for (size_t i = 0; i < n; i++) {{
                one[i] = samples[(DAVAR_SETUP_AXES * i) + a];
            }}
            davar_push_{suffix}(&gyro[a], one, n);
{cascade}        }}
        samples += DAVAR_SETUP_AXES * n;
        count -= n;
    }}
}}
"""

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


CURVE = {
    "arw": "",
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
CASCADE_HEADER = '#include "davar/cascade.h"\n\n'
STANDARD = "#include <math.h>\n#include <string.h>\n"


def source(design: Design, title: str, plan: str, whitening: Sequence[str], alone: bool) -> str:
    """davar_setup.c. plan: the text of the fit plan; whitening: settings of law glr; alone: see
    files().
    """
    wishes, slow = design.wishes, design.cascade_taus > 0
    suffix, sample = SUFFIX[wishes.type], SAMPLE[wishes.type]
    rate, scale = wishes.rate_hz, _scale(design)
    flat = FLAT if wishes.motion == "slow" else ""
    push = (PUSH_ONE if wishes.axes == 1 else PUSH_ALL).format(
        sample=sample,
        suffix=suffix,
        together=TOGETHER,
        cascade=""
        if not slow
        else f"    davar_cascade_push_{suffix}(&cascade[0], samples, count);\n"
        if wishes.axes == 1
        else f"            davar_cascade_push_{suffix}(&cascade[a], one, n);\n",
    )
    return SOURCE.format(
        title=title,
        includes="" if not slow else STANDARD if alone else CASCADE_HEADER + STANDARD,
        plan=plan,
        taus=", ".join(map(str, design.taus)),
        rate=rate,
        scale=scale,
        stride=design.stride,
        engine=_engine(design),
        window="\n    ".join(_window(design, whitening)),
        count=len(design.taus),
        memory=_memory(design),
        cascade=CASCADE.format(
            rate=rate,
            scale=scale,
            shortest=design.cascade_shortest,
            taus=design.cascade_taus,
            clusters=CASCADE_CLUSTERS,
            type=NUMBER[wishes.type],
        )
        if slow
        else "",
        suffix=suffix,
        start=""
        if not slow
        else "        if ((status == DAVAR_OK) &&\n"
        "            (DAVAR_CASCADE_OK !=\n"
        f"             davar_cascade_init_{suffix}(&cascade[a], &slow, stages[a],\n"
        "                                        sizeof stages[a]))) {\n"
        "            status = DAVAR_ERR_BUILD; /* the planner checked the settings */\n"
        "        }\n",
        push=push,
        gap="        davar_cascade_gap(&cascade[a], missing);\n" if slow else "",
        restart="        davar_cascade_reset(&cascade[a]);\n" if slow else "",
        curve=CURVE[design.fit].replace("{flat}", flat),
        flat=flat,
        white="davar_fit_white" if design.fit == "terms" else "davar_fit_white_ready",
    )


def cmake(design: Design) -> str:
    """davar_setup.cmake: to include before add_subdirectory of davar."""
    return "".join(
        'set({} {} CACHE STRING "made by tools/davar-plan" FORCE)\n'.format(*d.split("="))
        for d in defines(design)
    )


def with_options(design: Design, library: dict[str, str]) -> dict[str, str]:
    """The library as two files whose header has the options of the build."""
    defined = "".join(f"#define {d.replace('=', ' ')}\n" for d in defines(design))
    guard = "#define DAVAR_ONE_H\n"
    before, found, rest = library["davar.h"].partition(guard)
    assert found
    about = "/* The options of davar_setup.h, by tools/davar-plan. */"
    return {**library, "davar.h": f"{before}{guard}\n{about}\n{defined}{rest}"}


def files(
    design: Design, title: str, about: Sequence[str], library: dict[str, str] | None = None
) -> dict[str, str]:
    """Name -> content. about: lines for the comment at the top of the header. library: davar as two
    files, so that the folder compiles alone and without options; None: from a folder of davar.
    """
    long_taus, alone = design.long_taus if design.fit == "terms" else (), library is not None
    plan = programs.fit_plan(design.wishes, design.taus, long_taus)
    setup = {
        "davar_setup.h": header(design, title, about, alone),
        "davar_setup.c": source(design, title, plan.text, plan.whitening, alone),
    }
    if library is not None:
        return {**setup, **with_options(design, library)}
    return {
        **setup,
        "davar_setup.args": "".join(f"-D{define}\n" for define in defines(design)),
        "davar_setup.cmake": cmake(design),
    }
