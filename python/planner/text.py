"""The C text of a design: davar_setup.h, davar_setup.c and the options of the build."""

from collections.abc import Sequence

from . import programs
from .design import BLOCK, Design
from .parts import SAMPLE, SUFFIX, Part, flat, parts, scale

TOGETHER = 16  # samples of an axis that a push hands on at once


def defines(design: Design) -> list[str]:
    """The -D options of the build."""
    narrow = design.wishes.type == "int16"
    options = {
        "TAUS_MAX": design.taus_max,
        "Q31" if narrow else "Q15": 0,
        "LAWS": int(design.law == "glr"),
    }
    if design.engine == "small":
        options["FILTERS"] = int(design.filtered)
    return [f"DAVAR_{name}={value}" for name, value in options.items()]


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
{functions}
/* Returns to the state after davar_setup_start, counters included. Call it while no push is at
 * work, for example after the gyro was configured again. */
void davar_setup_restart(void);

/* Returns the counts of gaps, lost and clipped samples, missed results and alarms of an axis since
 * the start; all are 0 if there is no such axis. Call it in the main loop. davar_can_health copies
 * them to the counters of CAN and serial frames. */
davar_health_t davar_setup_health(uint8_t axis);
{instance}
/* Returns the configuration of all instances: rate, stride, window and cluster sizes. The encoder
 * of frames needs it (davar_encoder_init). */
const davar_config_t *davar_setup_config(void);

#ifdef __cplusplus
}}
#endif

#endif
"""

INSTANCE = """
/* Returns the instance of an axis, or null if there is no such axis. Other functions of davar need
 * it. A result that davar_take takes from it is missing in davar_setup_take. */
davar_t *davar_setup_instance(uint8_t axis);
"""


def header(design: Design, title: str, about: Sequence[str], alone: bool) -> str:
    """davar_setup.h. about: lines for the comment at the top; alone: see files()."""
    axes, chosen = design.wishes.axes, parts(design)
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
    small = ("small",) if design.engine == "small" else ()
    types = [name for part in chosen for name in part.types]
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
        else "\n".join(
            f'#include "davar/{name}.h"' for name in ("davar", "fit", *glr, *small, *types)
        ),
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
        functions="".join(part.comment for part in chosen),
        instance="" if small else INSTANCE,
    )


CONFIG = """static const uint32_t taus[] = {{{taus}}}; /* samples */
static const davar_config_t config = {{
    .rate_hz = {rate!r},
    {scale}
    .stride = {stride},{engine}
    {window}
    .taus = taus,
    .tau_count = {count},
}};
"""
SOURCE = """/* {title} davar_setup.h describes it. */
#include "davar_setup.h"
{includes}
{plan}
{config}static uint64_t memory[DAVAR_SETUP_AXES]
                      [{memory} / 8U];
static davar_t gyro[DAVAR_SETUP_AXES];
{declarations}
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
{functions}
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

SMALL = """/* {title} davar_setup.h describes it. */
#include "davar_setup.h"

{plan}
{config}static int16_t ring[{window} + 1];
static davar_small_t gyro;
static davar_result_t result;

davar_status_t davar_setup_start(void)
{{
    davar_small_start(&gyro, &davar_setup_plan, ring);
    return DAVAR_OK;
}}

void davar_setup_push(const int16_t *samples, size_t count)
{{
    davar_small_push(&gyro, samples, count);
}}

void davar_setup_gap(uint32_t missing)
{{
    davar_small_gap(&gyro, missing);
}}

const davar_result_t *davar_setup_take(uint8_t axis)
{{
    return ((axis == 0) && davar_small_take(&gyro, &result)) ? &result : NULL;
}}

void davar_setup_restart(void)
{{
    davar_small_restart(&gyro);
}}

davar_health_t davar_setup_health(uint8_t axis)
{{
    const davar_health_t none = {{0}};
    return (axis == 0) ? davar_small_health(&gyro) : none;
}}

const davar_config_t *davar_setup_config(void)
{{
    return &config;
}}
"""

PUSH_ONE = """void davar_setup_push(const {sample} *samples, size_t count)
{{
    davar_push_{suffix}(&gyro[0], samples, count);
{parts}}}
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
{parts}        }}
        samples += DAVAR_SETUP_AXES * n;
        count -= n;
    }}
}}
"""


def _includes(chosen: Sequence[Part], alone: bool) -> str:
    """Of davar_setup.c, besides its header."""
    own = [f'#include "davar/{name}.h"\n' for part in chosen for name in part.includes]
    standard = sorted({f"#include <{name}.h>\n" for part in chosen for name in part.standard})
    groups = ["".join(group) for group in ([] if alone else own, standard) if group]
    return "\n".join(groups)


def _push(design: Design, chosen: Sequence[Part]) -> str:
    """The function that passes samples on."""
    one = design.wishes.axes == 1
    names = (
        {"axis": "0", "samples": "samples", "count": "count"}
        if one
        else {"axis": "a", "samples": "one", "count": "n"}
    )
    indent = " " * (4 if one else 12)
    return (PUSH_ONE if one else PUSH_ALL).format(
        sample=SAMPLE[design.wishes.type],
        suffix=SUFFIX[design.wishes.type],
        together=TOGETHER,
        parts="".join(indent + part.push.format(**names) for part in chosen),
    )


def source(design: Design, title: str, plan: str, whitening: Sequence[str], alone: bool) -> str:
    """davar_setup.c. plan: the text of the fit plan; whitening: settings of law glr; alone: see
    files().
    """
    chosen = parts(design)
    config = CONFIG.format(
        taus=", ".join(map(str, design.taus)),
        rate=design.wishes.rate_hz,
        scale=scale(design),
        stride=design.stride,
        engine=_engine(design),
        window="\n    ".join(_window(design, whitening)),
        count=len(design.taus),
    )
    if design.engine == "small":
        return SMALL.format(title=title, plan=plan, config=config, window=design.window)
    return SOURCE.format(
        title=title,
        includes=_includes(chosen, alone),
        plan=plan,
        config=config,
        memory=_memory(design),
        suffix=SUFFIX[design.wishes.type],
        push=_push(design, chosen),
        flat=flat(design),
        white="davar_fit_white" if design.fit == "terms" else "davar_fit_white_ready",
        declarations="".join(part.declarations for part in chosen),
        start="".join(part.start for part in chosen),
        gap="".join(part.gap for part in chosen),
        restart="".join(part.restart for part in chosen),
        functions="".join(part.function for part in chosen),
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
    plan = (
        programs.small_plan(design.wishes, design.taus, design.window, design.stride)
        if design.engine == "small"
        else programs.fit_plan(design.wishes, design.taus, long_taus)
    )
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
