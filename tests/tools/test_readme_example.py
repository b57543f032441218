"""The firmware examples of all pages and header comments compile unchanged, without a warning. The
README's is short and measures the noise with the setup that its command writes.
"""

import math
import re

import c_library
import numpy as np
import pytest
from planner_case import ROOT, after_two_poles, gcc, printed_by, write

README = ROOT / "README.md"
PLANNER = ROOT / "docs/PLANNER.md"
FIRMWARE = ROOT / "docs/FIRMWARE.md"  # each block continues the one before
ALONE = [
    *(ROOT / "docs" / name for name in ("DIALECTS.md", "FLIGHT.md", "GYROS.md", "KALMAN.md")),
    ROOT / "packaging/common/README.md",
]
PUBLIC = (header for folder in c_library.PUBLIC for header in folder.rglob("*.h"))
HEADERS = sorted([*PUBLIC, *ROOT.glob("port/**/*.h")])
LINES_MAX = 15
STRICT = ("-Wall", "-Wextra", "-Werror")


def blocks(path):
    """The texts of the ```c blocks of a page, or of the comments of a header."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".h":
        text = re.sub(r"^ \* ?", "", text, flags=re.MULTILINE)
    return re.findall(r"^```c\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def listed(counts):
    return re.sub(r"\]", "}", re.sub(r"\[", "{", str(np.rint(counts).astype(int).tolist())))


BESIDE_README = """#include "davar_setup.h"
#include <stdio.h>
#include <stdlib.h>
static const int16_t counts[][3] = {counts};
void gyro_interrupt(const int16_t xyz[3]);
int main_loop(void (*report)(int axis, double arw, double low, double high));
const davar_result_t *take_after_a_sample(uint8_t axis);
const davar_result_t *take_after_a_sample(uint8_t axis)
{{
    static size_t next;
    if (next == sizeof counts / sizeof counts[0]) {{
        exit(0);
    }}
    if (axis == 0) {{
        gyro_interrupt(counts[next++]);
    }}
    return davar_setup_take(axis);
}}
static void report(int axis, double arw, double low, double high)
{{
    printf("%d %g %g %g\\n", axis, arw, low, high);
}}
int main(void)
{{
    return main_loop(report);
}}
"""


@pytest.mark.slow
def test_the_example_of_the_readme_measures_its_input(tmp_path):
    words = re.search(r"^tools/davar-plan (.*) -o \S+$", README.read_text(), re.MULTILINE)[1]
    write(words, tmp_path)
    # 1 deg/s is 16.4 counts; after the low-pass of 250 Hz at 1 kHz
    axes = np.array(
        [after_two_poles(0.25, 12000, np.random.default_rng(seed)) for seed in range(3)]
    )
    program = BESIDE_README.format(counts=listed(16.4 * axes.T))
    (tmp_path / "program.c").write_text(program, encoding="utf-8")
    (example,) = blocks(README)
    assert len(example.splitlines()) <= LINES_MAX
    (tmp_path / "example.c").write_text(example, encoding="utf-8")
    options = ("-O1", *STRICT, "@davar_setup.args")
    renamed = "-Ddavar_setup_take=take_after_a_sample"
    assert gcc(tmp_path, *options, renamed, "-c", "example.c") == ""
    sources = ["program.c", "davar_setup.c", *c_library.SOURCES]
    assert gcc(tmp_path, *options, "example.o", *sources, "-lm", "-o", "program") == ""
    lines = printed_by([tmp_path / "program"]).splitlines()
    axis, _, low, high = np.array([list(map(float, line.split())) for line in lines]).T
    assert set(axis) == {0, 1, 2}
    truth = 60 / math.sqrt(1000)  # N of 1 per root sample
    assert np.mean((low <= truth) & (truth <= high)) > 0.85


BESIDE_PLANNER = """#include "davar_setup.h"
#include <stdio.h>
static const int16_t counts[] = {counts};
bool noise_changed(uint8_t axis, davar_change_t *change);
int main(void)
{{
    davar_change_t change;
    if (davar_setup_start() != DAVAR_OK) {{
        return 1;
    }}
    for (int i = 0; i < (int)(sizeof counts / sizeof counts[0]); i++) {{
        davar_setup_push(&counts[i], 1);
        if (noise_changed(0, &change)) {{
            printf("%d %g %g\\n", i, change.older, change.newer);
        }}
    }}
    return 0;
}}
"""


def test_the_example_of_the_planner_s_page_reports_that_the_noise_has_doubled(tmp_path):
    write(
        "--rate 100 --lsb 0.05 --bandwidth none --core cortex-m4f --false-alarms-per-hour 0.1",
        tmp_path,
    )
    noise = np.random.default_rng(2).standard_normal(9000) * np.where(np.arange(9000) < 6000, 5, 10)
    (tmp_path / "program.c").write_text(BESIDE_PLANNER.format(counts=listed(noise)))
    (tmp_path / "example.c").write_text(blocks(PLANNER)[0])
    sources = ["example.c", "program.c", "davar_setup.c", *c_library.SOURCES]
    options = ("-O1", *STRICT, "@davar_setup.args")
    assert gcc(tmp_path, *options, *sources, "-lm", "-o", "program") == ""
    (line,) = printed_by([tmp_path / "program"]).splitlines()
    at, older, newer = map(float, line.split())
    assert 6000 < at < 6200
    assert (older, newer) == (pytest.approx(0.25, rel=0.1), pytest.approx(0.5, rel=0.3))


BESIDE_FLIGHT = """#include "davar_setup.h"
#include <stdio.h>
static const int16_t counts[] = {counts};
void check_noise(void);
void report(uint8_t axis, float high);
void report(uint8_t axis, float high)
{{
    printf("%d %g\\n", axis, (double)high);
}}
int main(void)
{{
    if (davar_setup_start() != DAVAR_OK) {{
        return 1;
    }}
    for (int i = 0; i < (int)(sizeof counts / sizeof counts[0]); i++) {{
        davar_setup_push(&counts[i], 1);
        check_noise();
    }}
    return 0;
}}
"""


def test_the_example_for_flight_reports_limits_above_the_noise(tmp_path):
    words = "--rate 1000 --lsb 0.05 --bandwidth none --core cortex-m4f --motion flight"
    write(words, tmp_path)
    noise = np.random.default_rng(3).normal(0, 5, 10000)
    (tmp_path / "program.c").write_text(BESIDE_FLIGHT.format(counts=listed(noise)))
    (tmp_path / "example.c").write_text(blocks(PLANNER)[1])
    sources = ["example.c", "program.c", "davar_setup.c", *c_library.SOURCES]
    options = ("-O1", *STRICT, "@davar_setup.args")
    assert gcc(tmp_path, *options, *sources, "-lm", "-o", "program") == ""
    lines = [line.split() for line in printed_by([tmp_path / "program"]).splitlines()]
    truth = 60 * 5 * 0.05 / 1000**0.5
    assert {axis for axis, _ in lines} == {"0"}
    assert len(lines) == (10000 - 32) // 256 - 3
    assert np.median([float(high) for _, high in lines]) == pytest.approx(1.1 * truth, rel=0.1)
    assert np.mean([float(high) > truth for _, high in lines]) > 0.9


BESIDE_FIRMWARE = """
#include <stdio.h>
int main(void)
{{
    static const int16_t counts[] = {counts};
    static davar_result_t result;
    if (gyro_start() != DAVAR_OK) {{
        return 1;
    }}
    for (int i = 0; i < 6000; i++) {{
        gyro_interrupt(counts[i]);
        if (gyro_noise(&result)) {{
            const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%g %g %g\\n", arw->value, arw->low, arw->high);
        }}
    }}
    return 0;
}}
"""


def test_the_example_by_hand_measures_its_input(library, tmp_path):
    # 20 counts are 1 deg/s: 6 deg/sqrt(h) at 100 Hz, after a low-pass at 33 Hz
    counts = listed(20 * after_two_poles(0.33, 6000, np.random.default_rng(1)))
    example = blocks(FIRMWARE)[0]
    assert len(example.splitlines()) <= LINES_MAX
    (tmp_path / "example.c").write_text(example + BESIDE_FIRMWARE.format(counts=counts))
    assert gcc(tmp_path, "-O1", "example.c", library, "-lm", "-o", "example") == ""
    lines = printed_by([tmp_path / "example"]).splitlines()
    value, low, high = np.array([list(map(float, line.split())) for line in lines]).T
    assert len(value) > 80
    assert np.mean((low <= 6) & (high >= 6)) > 0.85
    assert np.median((high - low) / 2 / value) == pytest.approx(0.08, abs=0.01)  # as on the page


def complaints(folder, text, *flags):
    (folder / "text.c").write_text(text)
    return gcc(folder, *STRICT, *flags, "-c", "text.c")  # some warnings need all passes


def test_the_examples_compile_without_a_warning(tmp_path):
    whole = "\n".join(blocks(FIRMWARE))
    assert complaints(tmp_path, whole) == ""
    assert "no_such_field" in complaints(tmp_path, whole.replace(".stride", ".no_such_field"))
    for path in ALONE + HEADERS:
        for block in blocks(path):
            text = f'#include "davar/davar.h"\n#include "davar/fit.h"\n{block}'
            assert complaints(tmp_path, text, "-Wno-unused-variable") == "", path.name


def test_no_example_is_elsewhere():
    assert [path.name for path in HEADERS if blocks(path)] == ["instance.h", "types.h"]
    folders = [path for path in ROOT.iterdir() if path.name not in ("build", ".git")]
    pages = [page for one in folders for page in (one.rglob("*.md") if one.is_dir() else [one])]
    found = [page for page in pages if page.suffix == ".md" and blocks(page)]
    assert sorted(found) == sorted([README, FIRMWARE, PLANNER, *ALONE])
