"""Runs every command of the pages and of --help, as typed, in a fresh clone that builds what it
needs.

command_rows.py lists the commands that another test or only tools/soak runs. The operands of
davarlab are then parsed, and the options of other programs looked up in their --help. So are those
of a command in running text without its operands (`davarlab live`, `davar-sim --device COMMAND`).
"""

import contextlib
import gzip
import io
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
import typed_commands
import writing_logs
from command_rows import ROWS, row_of
from davarlab import cli

ROOT = Path(__file__).resolve().parents[2]
VENV = ROOT / "build/venv-test"
PLACEHOLDER = re.compile(r"\[.*|\w+\]|[A-Z][A-Z_]*(\.\w+)*/?|-.*")
LONGEST_S = 1800  # after this time a command counts as hung
BOARDS = 8
PROGRAMS = sorted(
    path.name for path in (ROOT / "tools").iterdir() if path.is_file() and os.access(path, os.X_OK)
)
WORK = """[sensor]
rate_hz = 200.0
column = "gyro_x_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 3.0
"""
LIMITS = """[[limit]]
coefficient = "angle_random_walk.coefficient_deg_per_sqrt_h"
max = 1000.0
"""
APP = """#include "davar/davar.h"
#include "davar/fit.h"
void _exit(int status) { (void)status; for (;;) {} }
int main(void) { return (int)davar_health((const davar_t *)0x20000000).gaps; }
"""
# Files that the commands write outside of build/.
WRITTEN = re.compile(
    r"\?\? (FOLDER/|OUT/|model_|(stream\.tar\.gz|arw\.csv|plan\.c|my\.dbc|sheet\.toml|model\.toml"
    r"|imu\.yaml|a\.out)$)"
)


def everything():
    """Every command, in the order of the pages, each text once; from a block if there is one."""
    found = {}
    for page, text in typed_commands.pages(ROOT).items():
        for one in typed_commands.of_page(page, text):
            if one.text not in found or (one.block and not found[one.text].block):
                found.pop(one.text, None)
                found[one.text] = one
    return list(found.values())


def is_name(one):
    """Command in running text without operands: a command of the program, options, placeholders."""
    words = one.text.split()[1:]
    if words and re.fullmatch(r"[a-z]+", words[0]) and one.text.split()[0].endswith("davarlab"):
        words = words[1:]
    return (
        not one.block
        and not row_of(one.text).replaced[0]
        and all(PLACEHOLDER.fullmatch(word) for word in words)
    )


COMMANDS = everything()
RUN = [one for one in COMMANDS if not row_of(one.text).elsewhere and not is_name(one)]
PAGES = dict.fromkeys(one.page for one in RUN)
LONG_PAGES = dict.fromkeys(one.page for one in RUN if row_of(one.text).soak)


def recording(rows):
    lines = (
        f"{i / 100:.2f},{i * 7919 % 101 * 0.05:.2f},{(i * 7919 + 31) % 101 * 0.05:.2f}\n"
        for i in range(rows)
    )
    return "time_s,gyro_x_dps,gyro_y_dps\n" + "".join(lines)


def furnish(folder):
    """The files that the pages call REC, LOG, flight.csv ... Those for a log are a PX4 log with a
    gyro as its first sensor.
    """
    for name in ("flight.csv", "REC.csv", "REC"):
        (folder / name).write_text(recording(7000))
    for name in ("flight.csv.gz", "REC.csv.gz"):
        (folder / name).write_bytes(gzip.compress(recording(1500).encode()))
    (folder / "MODEL.toml").write_text(WORK)
    (folder / "LIMITS.toml").write_text(LIMITS)
    (folder / "app.c").write_text(APP)
    (folder / "logs").mkdir()
    truth = writing_logs.Truth(6000)
    writing_logs.ulog(folder / "LOG", truth)
    for lot in "ab":
        writing_logs.ulog(folder / f"logs/lot-{lot}.ulg", truth, gyros=1)
    (folder / "build/better.toml").write_text(WORK.replace("200.0", "50.0"))


def environment_of(clone, name, requirements):
    """Gives the clone the environment of the tests as its environment `name`, which is a part."""
    folder = clone / "build" / name
    folder.mkdir()
    for part in ("bin", "lib", "pyvenv.cfg"):
        (folder / part).symlink_to(VENV / part)
    shutil.copy(clone / requirements, folder / "requirements.txt")


class Clone:
    """A clone of this checkout, with uncommitted changes, in which a user types commands."""

    def __init__(self, folder):
        self.folder, home = folder / "davar", folder / "home"
        home.mkdir()
        words = ["git", "clone", "--quiet", "--shared", "--no-checkout", ROOT, self.folder]
        subprocess.run(words, check=True)
        self.git("reset", "--quiet")
        for name in typed_commands.tree(ROOT):
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, self.folder / name)
        (self.folder / "build").mkdir()
        environment_of(self.folder, "venv", "tools/requirements.txt")
        environment_of(self.folder, "venv-lab", "tools/requirements-lab.txt")
        for name in ("cache", "venv-bench", "venv-packages"):  # tools/soak makes them
            if (ROOT / "build" / name).exists():
                (self.folder / "build" / name).symlink_to(ROOT / "build" / name)
        furnish(self.folder)
        ours = ("build/tools/host_sim", "tools", "build/venv-packages/bin")
        path = [*(str(self.folder / one) for one in ours), os.environ["PATH"]]
        self.environment = {
            name: value
            for name, value in os.environ.items()
            if name not in ("PYTHONPATH", "VIRTUAL_ENV") and not name.startswith("DAVAR_")
        } | {"PATH": ":".join(path), "HOME": str(home), "MPLCONFIGDIR": str(home)}
        if shutil.which("ccache"):
            cache = os.environ.get("CCACHE_DIR", str(Path.home() / ".cache/ccache"))
            self.environment |= {"CMAKE_C_COMPILER_LAUNCHER": "ccache", "CCACHE_DIR": cache}
            self.environment |= {"CCACHE_BASEDIR": str(self.folder), "CCACHE_NOHASHDIR": "1"}
        self.said, self.before = folder / "said", self.changes()

    def git(self, *words):
        return subprocess.run(
            ["git", *words], cwd=self.folder, text=True, stdout=subprocess.PIPE, check=True
        ).stdout

    def changes(self):
        return set(self.git("status", "--short", "--untracked-files=all").splitlines())

    def run(self, text, ready="", status=0):
        """Runs a command to its end, or until its output has `ready`. Returns its output."""
        with self.said.open("wb") as said:
            process = subprocess.Popen(
                ["bash", "-c", text],
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        wanted = {status}
        try:
            if ready:
                self.wait_for(ready, process)
                os.killpg(process.pid, signal.SIGINT)
                wanted |= {-signal.SIGINT, 128 + signal.SIGINT}
            found = process.wait(LONGEST_S)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        output = self.said.read_text(errors="replace")
        assert found in wanted, f"{text}: exit status {found}\n{output[-3000:]}"
        return output

    def wait_for(self, ready, process):
        end = time.monotonic() + LONGEST_S
        while not re.search(ready, self.said.read_text(errors="replace")):
            assert process.poll() is None and time.monotonic() < end, self.said.read_text()
            time.sleep(0.1)


@pytest.fixture(scope="session")
def clone(tmp_path_factory):
    return Clone(tmp_path_factory.mktemp("clone"))


# Files that the commands of a page leave below build/, by page.
LEFT = {
    "docs/PACKAGES.md": (
        "build/root/include/davar/davar.h",
        "build/root/**/libdavar.a",
        "build/root/**/davar.pc",
        "build/deb/libdavar-dev_*.deb",
        "build/deb/davar-tools_*.deb",
        "build/packages/SHA256SUMS",
        "build/packages/*.deb",
    ),
}


def run_page(clone, page, long, patterns=()):
    """Runs the commands of a page in their order; the long ones only if `long`. Then each pattern
    of `patterns` has a file.
    """
    wrong = []
    for one in RUN:
        row = row_of(one.text)
        if one.page != page or (row.soak and not long):
            continue
        word, value = row.replaced
        text = re.sub(rf"\b{word}\b", value, one.text) if word else one.text
        try:
            if row.before:
                clone.run(row.before)
            clone.run(text, row.ready, row.status)
        except (AssertionError, subprocess.TimeoutExpired) as why:
            wrong.append(str(why))
    assert not wrong, "\n".join(wrong)
    left = clone.changes() - clone.before
    assert [line for line in left if not WRITTEN.match(line)] == []
    assert [pattern for pattern in patterns if not any(clone.folder.glob(pattern))] == []


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page(clone, page):
    run_page(clone, page, long=False)


@pytest.mark.soak
@pytest.mark.parametrize("page", LONG_PAGES)
def test_all_commands_of_a_page(clone, page):
    run_page(clone, page, long=True, patterns=LEFT.get(page, ()))


@pytest.mark.parametrize("program", PROGRAMS)
def test_help_and_its_examples(clone, program):
    said = clone.run(f"tools/{program} --help")
    assert re.match(rf"usage: (tools/)?{program}\b", said)
    known = {one.text for one in COMMANDS}
    for one in typed_commands.of_help(f"tools/{program}", said):
        if one.text not in known:
            clone.run(one.text)


def help_of(words):
    """davarlab WORDS --help, in this process."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), pytest.raises(SystemExit) as end:
        cli.parser().parse_args([*words, "--help"])
    assert end.value.code == 0
    return said.getvalue()


def test_commands_that_are_not_run_here_parse(clone):
    helps = {"davar-sim": clone.run("tools/davar-sim --help")}
    helps["davar-mcu"] = helps["davar-sim"] + clone.run("tools/davar-mcu --help")
    for one in COMMANDS:
        program, *words = one.text.replace("'", "").split()
        program = program.removeprefix("tools/")
        if (
            program not in PROGRAMS
            or not program.startswith("davar")
            or not (is_name(one) or row_of(one.text).elsewhere)
        ):
            continue
        if program == "davarlab" and not is_name(one):
            cli.parser().parse_args(words)  # or it exits
            continue
        if program == "davarlab":
            text = help_of([word for word in words[:1] if word[0] != "-"])
        else:
            if program not in helps:
                helps[program] = clone.run(f"tools/{program} --help")
            text = helps[program]
        for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", one.text):
            assert re.search(rf"(?<![\w-]){option}(?![\w-])", text), one


def test_every_row_has_its_command_and_its_test():
    for row in ROWS:
        found = [one for one in COMMANDS if re.fullmatch(row.pattern, one.text)]
        assert found, f"no page has a command like {row.pattern}"
        assert not row.elsewhere.startswith("tests/") or (ROOT / row.elsewhere).is_file(), row


def test_named_parts_and_suites_exist(clone):
    parts = {line.split()[0] for line in clone.run("tools/test --list").splitlines()}
    suites = subprocess.run(
        ["ctest", "--test-dir", ROOT / "build/release", "-N"], text=True, stdout=subprocess.PIPE
    ).stdout
    wrong = []
    for one in COMMANDS:
        for names in re.findall(r"tools/test --only (\S+)", one.text):
            wrong += [(one.page, name) for name in names.split(",") if name not in parts]
        for name in re.findall(r"ctest -R (\S+)", one.text):
            wrong += [] if re.search(rf": {name}", suites) else [(one.page, name)]
    assert wrong == []


@pytest.mark.soak
def test_the_benchmark_measures_everything(clone):
    said = clone.run("tools/davar-bench --json")
    found = json.loads(re.sub(r"^davar-bench: .*\n", "", said, flags=re.MULTILINE))
    assert set(found) == {"host", "csv", "python", "targets"}
    assert len(found["targets"]) == BOARDS
    groups = (found[name].values() for name in ("csv", "python", "targets"))
    for figures in (found["host"], *itertools.chain(*groups)):
        for name, value in figures.items():
            assert value is not None and value >= 0, name
