"""The linters: layout, common mistakes and types of C, Python, shell and the workbench's page."""

import functools
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import c_library
import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
WITH_C = ("lib", "addons", "port", "host_sim", "gateway", "examples", "python")
WITH_C += ("tests", "tools", "bench")
CPPCHECK = "cppcheck --quiet --error-exitcode=1 --std=c11 --inline-suppr -j2"
CPPCHECK += " --suppressions-list=cmake/cppcheck.txt"
INCLUDES = (*c_library.PUBLIC, "port/include", "port/node", "host_sim")
BESIDE = Path(sys.executable).parent  # programs of the tests' own Python
PAGE = ("python/davarlab/workbench/page", "python/davarlab/report")  # its .js and .css


def run(*words):
    """The output of a linter, which must succeed."""
    done = subprocess.run([*map(str, words)], cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def sources(*suffixes):
    """All files with these suffixes in folders with C code, relative to the root."""
    return sorted(
        str(path.relative_to(ROOT))
        for folder in WITH_C
        for path in (ROOT / folder).rglob("*")
        if path.suffix in suffixes and "build" not in path.parts
    )


def test_clang_format():
    run("clang-format", "--dry-run", "-Werror", *sources(".c", ".h", ".inc"))


@pytest.mark.slow
def test_cppcheck():
    kinds = "--enable=warning,style,performance,portability"
    folders = ("lib/src", "addons", "port", "host_sim", "gateway", "python")
    run(*CPPCHECK.split(), kinds, *(f"-I{one}" for one in INCLUDES), *folders)


@pytest.mark.slow
def test_misra_has_the_places_of_its_page(tmp_path):
    """Per rule of MISRA C:2012, lib/ and addons/ have as many violations as the page lists."""
    words = "--quiet --std=c11 --platform=unix64 --addon=misra --enable=style --max-configs=1 -j2"
    words += f" --template={{file}}:{{line}}:~{{id}} --cppcheck-build-dir={tmp_path}"
    command = [word.replace("~", " ") for word in words.split()]
    output = run("cppcheck", *command, *c_library.FLAGS, "lib/src", "addons")
    places = {line for line in output.splitlines() if "misra-c2012-" in line}
    page = (ROOT / "docs/quality/MISRA.md").read_text()
    rows = re.findall(r"^\| (\d+\.\d+) \| \w+ \| (\d+) \|", page, re.MULTILINE)
    assert places
    assert Counter(line.rsplit("-", 1)[1] for line in places) == {
        rule: int(count) for rule, count in rows
    }, "docs/quality/MISRA.md has other numbers"


@functools.cache
def compile_commands():
    """{source: its entry of compile_commands.json}."""
    listed = BUILD / "debug/compile_commands.json"
    entries = json.loads(listed.read_text()) if listed.exists() else []
    return {os.path.relpath(entry["file"], ROOT): entry for entry in entries}


@functools.cache
def headers():
    """Every header of the tree: what a source may include. One list, since a change is rare."""
    return tuple(name for name in sources(".h", ".inc"))


def tidied():
    for source in sorted(set(compile_commands()) & set(sources(".c"))):
        marks = [pytest.mark.slow, pytest.mark.xdist_group(f"tests/test_lint.py::{source}")]
        marks += [pytest.mark.soak] if source.startswith("tests/") else []
        settings = (".clang-tidy", "tests/.clang-tidy")
        marks.append(pytest.mark.inputs(source, *included(source), *settings))
        yield pytest.param(source, marks=marks, id=source)


def included(source):
    """The headers of the tree that a source reads, from the compiler's list; without one, all."""
    entry = compile_commands()[source]
    words = shlex.split(entry["command"])
    made = Path(entry["directory"], words[words.index("-o") + 1] + ".d")
    if not made.exists():
        return headers()
    names = made.read_text().replace("\\\n", " ").split(":", 1)[1].split()
    paths = (os.path.normpath(os.path.join(entry["directory"], name)) for name in names)
    above = f"{ROOT}/"
    return tuple(path.removeprefix(above) for path in paths if path.startswith(above))


TIDIED = list(tidied())


@pytest.mark.parametrize("source", TIDIED)
def test_clang_tidy(source):
    run("clang-tidy", "--quiet", "--checks=-clang-analyzer-*", "-p", "build/debug", source)


@pytest.mark.soak
@pytest.mark.parametrize("source", TIDIED)
def test_clang_tidy_with_its_analyzer(source):
    """The analyzer follows paths, up to half a minute for a file; the rest takes half a second."""
    run("clang-tidy", "--quiet", "-p", "build/debug", source)


def test_ruff_format():
    run(BESIDE / "ruff", "format", "--check")


def test_ruff():
    run(BESIDE / "ruff", "check", "--output-format=concise")


def test_mypy():
    run(BESIDE / "mypy")


def test_shellcheck():
    scripts = [
        path.relative_to(ROOT)
        for path in [*(ROOT / "tools").rglob("*"), ROOT / ".ci/run", ROOT / "bench/run"]
        if path.is_file()
        and (path.suffix == ".sh" or path.read_bytes().startswith(b"#!/usr/bin/env bash"))
    ]
    assert shutil.which("shellcheck") and scripts
    run("shellcheck", "--external-sources", "--source-path=SCRIPTDIR", *sorted(scripts))


@pytest.fixture(scope="module")
def node():
    """Runs a program of a pinned package of npm. Returns its exit status and output."""
    made = subprocess.run(
        ["bash", "-c", ". tools/support/setup.sh && node_packages"],
        cwd=ROOT,
        text=True,
        capture_output=True,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    programs = Path(made.stdout.strip()) / "node_modules/.bin"

    def run_program(name, *words):
        done = subprocess.run([programs / name, *words], cwd=ROOT, text=True, capture_output=True)
        return done.returncode, done.stdout + done.stderr

    return run_program


def test_prettier(node):
    status, output = node("prettier", "--check", *(f"{one}/**/*.{{js,css}}" for one in PAGE))
    assert status == 0, output


def test_tsc(node):
    status, output = node("tsc", "--project", "python")
    assert status == 0, output


CHANGES = {
    "a method that the report calls": (
        "chart/allan.js",
        "    showBefore(",
        "    showPrevious(",
        "report/drawing.js",
    ),
    "a module": ("main.js", "/page/api.js", "/page/apis.js", "page/main.js"),
    "a function": ("words.js", "export function duration(", "function duration(", "chart/scale.js"),
    "an argument": ("words.js", "duration(s, digits = 3)", "duration()", "chart/scale.js"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_tsc_finds(change, node, tmp_path):
    """A change of one module breaks another one that uses it."""
    module, old, new, user = CHANGES[change]
    for name in ("tsconfig.json", "page.d.ts"):
        shutil.copy(ROOT / "python" / name, tmp_path)
    for folder in PAGE:
        target = tmp_path / Path(folder).relative_to("python")
        shutil.copytree(ROOT / folder, target)
    changed = tmp_path / "davarlab/workbench/page" / module
    text = changed.read_text()
    assert old in text
    changed.write_text(text.replace(old, new))
    status, output = node("tsc", "--project", tmp_path)
    assert status and user in output, output
