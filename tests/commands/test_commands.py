"""Runs every command of the pages and of --help, as typed, in a fresh clone.

The clone has the caches of this checkout (compiled objects, Python environments); everything that
is built, is built there. tables.py lists commands that cannot run here, by their text and with the
reason. A command in running text without its operands (`davarlab live`, `davar-sim --device
COMMAND`) is checked against --help: the program, its command and the options must exist.
"""

import gzip
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/lab"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import release
import tables
import typed
import writing_logs

ROOT = Path(__file__).resolve().parents[2]

PLACEHOLDER = re.compile(r"\[.*|\w+\]|[A-Z][A-Z_]*(\.\w+)*/?|-.*")
LONGEST_S = 1800  # after this time a command counts as hung
TARGETS = 8
WORK = """[sensor]
rate_hz = 200.0
column = "gyro_x_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 3.0
"""
APP = """#include "davar/davar.h"
void _exit(int status) { (void)status; for (;;) {} }
int main(void) { return (int)davar_health((const davar_t *)0x20000000).gaps; }
"""


def fresh_clone(folder):
    """A clone of this checkout, with uncommitted changes and the caches."""
    clone = Path(folder) / "davar"
    if (ROOT / ".git").exists():
        subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", ROOT, clone], check=True)
    here = set(release.tree())
    for path in [path for path in clone.rglob("*") if path.is_file() and ".git" not in path.parts]:
        if path.relative_to(clone).as_posix() not in here:
            path.unlink()
    for name in here:
        release.copy(ROOT / name, clone / name)
    (clone / "build").mkdir()
    for path in [ROOT / "build/cache", *(ROOT / "build").glob("venv*")]:
        (clone / "build" / path.name).symlink_to(path.resolve())
    return clone


def recording(rows, columns=("gyro_x_dps", "gyro_y_dps")):
    lines = [
        ",".join(f"{(i * 7919 + 31 * c) % 101 * 0.05:.2f}" for c in range(len(columns)))
        for i in range(rows)
    ]
    return f"time_s,{','.join(columns)}\n" + "".join(
        f"{i / 100:.2f},{line}\n" for i, line in enumerate(lines)
    )


def furnish(folder):
    """The files that the pages call REC, LOG, flight.csv ... Those for a log are a PX4 log with a
    gyro as its first sensor.
    """
    for name in ("flight.csv", "REC.csv", "REC"):
        (folder / name).write_text(recording(7000))
    for name in ("flight.csv.gz", "REC.csv.gz"):
        (folder / name).write_bytes(gzip.compress(recording(1500).encode()))
    (folder / "MODEL.toml").write_text(WORK)
    (folder / "LIMITS.toml").write_text(
        '[[limit]]\ncoefficient = "angle_random_walk.coefficient_deg_per_sqrt_h"\nmax = 1000.0\n'
    )
    (folder / "app.c").write_text(APP)
    (folder / "logs").mkdir()
    truth = writing_logs.Truth(6000)
    writing_logs.ulog(folder / "LOG", truth)
    for lot in "ab":
        writing_logs.ulog(folder / f"logs/lot-{lot}.ulg", truth, gyros=1)


def surroundings(clone, home):
    """The user's environment: programs of the packages on the path, a home, a Python environment to
    install into.
    """
    home.mkdir()
    subprocess.run([sys.executable, "-m", "venv", home / "python"], check=True)
    path = [
        clone / "build/tools/host_sim",
        clone / "tools",
        home / "python/bin",
        ROOT / "build/venv-packages/bin",
    ]
    outer = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "DAVAR_LAB_LIBRARY", "VIRTUAL_ENV")
    }
    return {
        **outer,
        "PATH": ":".join([*map(str, path), os.environ["PATH"]]),
        "HOME": str(home),
        "MPLCONFIGDIR": str(home),
        "PIP_CACHE_DIR": os.environ.get("PIP_CACHE_DIR", str(Path.home() / ".cache/pip")),
    }


def everything():
    """Every command, in the order of the pages, each text once; from a block if there is one."""
    found = {}
    for page, text in typed.pages(ROOT).items():
        for one in typed.of_page(page, text):
            if one.text not in found or (one.block and not found[one.text].block):
                found.pop(one.text, None)
                found[one.text] = one
    return list(found.values())


def is_name(one):
    """Command in running text without operands: a command of the program, options, placeholders."""
    words = one.text.split()[1:]
    if words and re.fullmatch(r"[a-z]+", words[0]) and re.search(r"davarlab$", one.text.split()[0]):
        words = words[1:]
    return (
        not one.block
        and one.text not in tables.REPLACED
        and all(PLACEHOLDER.fullmatch(word) for word in words)
    )


def is_elsewhere(one):
    """Cannot run here, or another test runs it."""
    return (
        one.text in tables.NOT_RUN
        or one.text in tables.RUN_BY
        or bool(tables.TESTS.match(one.text))
    )


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.clone = fresh_clone(folder.name)
        furnish(cls.clone)
        cls.environment = surroundings(cls.clone, Path(folder.name) / "home")
        cls.known, cls.seconds, cls.output = everything(), {}, {}
        cls.before = set(cls.files())

    @classmethod
    def files(cls):
        return subprocess.run(
            ["git", "status", "--short", "--untracked-files=all"],
            cwd=cls.clone,
            text=True,
            stdout=subprocess.PIPE,
            check=True,
        ).stdout.splitlines()

    def setUp(self):
        self.said = self.enterContext(tempfile.TemporaryFile())

    def start(self, text):
        self.said.seek(0)
        self.said.truncate()
        return subprocess.Popen(
            ["bash", "-c", text],
            cwd=self.clone,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=self.said,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def heard(self):
        self.said.seek(0)
        return self.said.read().decode(errors="replace")

    def run_typed(self, text, wanted=0):
        """Runs it to its end and returns its output."""
        begun = time.monotonic()
        process = self.start(text)
        try:
            status = process.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            status = process.wait() and "no end"
        self.seconds[text] = time.monotonic() - begun
        self.assertEqual(wanted, status, f"{text}\n{self.heard()[-3000:]}")
        return self.heard()

    def run_until_ready(self, text, ready, stop):
        process = self.start(text)
        try:
            begun = time.monotonic()
            while (
                not re.search(ready, self.heard())
                and process.poll() is None
                and time.monotonic() - begun < LONGEST_S
            ):
                time.sleep(0.1)
            self.assertRegex(self.heard(), ready, text)
            number = getattr(signal, stop)
            os.killpg(process.pid, number)
            self.assertIn(
                process.wait(LONGEST_S),
                (tables.STATUS.get(text, 0), -number, 128 + number),
                f"{text}\n{self.heard()[-3000:]}",
            )
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()

    def typed(self, text):
        """The command as a reader types it, with placeholders replaced."""
        for word, value in tables.REPLACED.get(text, {}).items():
            text = re.sub(rf"\b{word}\b", value, text)
        return text

    def test_a_every_command_does_what_it_should(self):
        for one in self.known:
            if is_elsewhere(one) or is_name(one):
                continue
            with self.subTest(page=one.page, command=one.text):
                if one.text in tables.BEFORE:
                    self.run_typed(tables.BEFORE[one.text])
                if one.text in tables.UNTIL_STOPPED:
                    self.run_until_ready(one.text, *tables.UNTIL_STOPPED[one.text])
                else:
                    self.output[one.text] = self.run_typed(
                        self.typed(one.text), tables.STATUS.get(one.text, 0)
                    )
        print(
            "\nlongest:",
            *(
                f"{seconds:.0f} s {text[:60]}"
                for text, seconds in sorted(self.seconds.items(), key=lambda pair: -pair[1])[:8]
            ),
            sep="\n  ",
        )

    def test_b_the_benchmark_measures_everything(self):
        found = json.loads(
            re.sub(
                r"^davar-bench: .*\n",
                "",
                self.run_typed("tools/davar-bench --json"),
                flags=re.MULTILINE,
            )
        )
        self.assertEqual({"host", "csv", "python", "targets"}, set(found))
        self.assertEqual(TARGETS, len(found["targets"]))
        groups = (found[name].values() for name in ("csv", "python", "targets"))
        for figures in (found["host"], *itertools.chain(*groups)):
            for name, value in figures.items():
                self.assertIsNotNone(value, name)
                self.assertGreaterEqual(value, 0, name)

    def test_c_the_output_of_the_recipes_of_the_packages(self):
        for pattern in (
            "build/root/include/davar/davar.h",
            "build/root/**/libdavar.a",
            "build/root/**/davar.pc",
            "build/deb/libdavar-dev_*.deb",
            "build/deb/davar-tools_*.deb",
            "build/packages/SHA256SUMS",
            "build/packages/*.deb",
        ):
            self.assertTrue(list(self.clone.glob(pattern)), pattern)

    def test_d_the_examples_of_help(self):
        programs = sorted(
            path
            for path in (ROOT / "tools").iterdir()
            if path.is_file() and os.access(path, os.X_OK)
        )
        self.assertGreater(len(programs), 8)
        examples = 0
        for path in programs:
            said = self.run_typed(f"tools/{path.name} --help")
            for one in typed.of_help(f"tools/{path.name}", said):
                examples += 1
                if one.text in self.output:
                    continue  # a page has it too
                with self.subTest(page=one.page, command=one.text):
                    self.run_typed(one.text)
        self.assertGreater(examples, 4)

    def test_e_files_in_the_pages_exist(self):
        helps = {}
        for one in filter(is_name, self.known):
            if is_elsewhere(one):
                continue
            with self.subTest(page=one.page, command=one.text):
                words = one.text.split()
                sub = (
                    words[1]
                    if words[0].endswith("davarlab") and re.fullmatch("[a-z]+", words[1])
                    else ""
                )
                key = f"{words[0]} {sub} --help".replace("  ", " ")
                if key not in helps:
                    helps[key] = self.run_typed(key)
                for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", one.text):
                    self.assertRegex(helps[key], rf"(?<![\w-]){option}(?![\w-])")

    def test_f_the_tables_have_no_removed_entries(self):
        there = {one.text for one in self.known}
        for name in ("NOT_RUN", "RUN_BY", "UNTIL_STOPPED", "REPLACED", "STATUS", "BEFORE"):
            self.assertEqual([], sorted(set(getattr(tables, name)) - there), name)
        self.assertEqual(set(), set(tables.NOT_RUN) & set(tables.RUN_BY))
        pages = {one.text: one.page for one in self.known}
        for text, test in tables.RUN_BY.items():
            self.assertTrue((ROOT / test).is_file(), test)
            program, *operands = text.split()
            said = (ROOT / test).read_text(encoding="utf-8")
            quoted = ", ".join(
                f'"{word}"' for word in operands
            )  # unchanged, or taken from the page; the call may take several lines
            self.assertTrue(
                str(pages[text]) in said
                or (program in said and quoted in re.sub(r"\s+", " ", said)),
                f"{test} does not run {text}",
            )
        parts = {line.split()[0] for line in self.run_typed("tools/test --list").splitlines()}
        for text in there:
            for names in re.findall(r"tools/test --only (\S+)", text):
                self.assertLessEqual(set(names.split(",")), parts, text)
        listed = (ROOT / "tests/CMakeLists.txt").read_text(encoding="utf-8")
        built = re.findall(r"\b(?:davar_test\(|NAME )(\w+)[ /](\w+)", listed)
        for text in there:
            for name in re.findall(r"ctest -R (\S+)", text):
                self.assertTrue(any("/".join(one).startswith(name) for one in built), text)

    def test_g_the_clone_has_only_the_expected_changes(self):
        named = {
            "stream.tar.gz",
            "arw.csv",
            "plan.c",
            "my.dbc",
            "sheet.toml",
            "model.toml",
            "model_gyro_x.toml",
            "imu.yaml",
            "a.out",
        }
        left = [
            line
            for line in self.files()
            if line not in self.before
            and Path(line[3:]).name not in named
            and not re.match(r"\?\? (OUT|FOLDER)/|\?\? model_", line)
        ]
        self.assertEqual([], left)


if __name__ == "__main__":
    unittest.main()
