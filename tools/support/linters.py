"""Runs the linters: clang-format, clang-tidy, cppcheck, shellcheck, ruff and mypy. Standard library
only.
"""

import json
import os
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import result_cache
from c_suites import build, sources
from python_suites import environment
from runner import BUILD, JOBS, ROOT, Broken, Tally, once, run, tool


def clang_format() -> Tally:
    return tool("clang-format", "--dry-run", "-Werror", *sources(".c", ".h", ".inc"))


@once
def tidy_entries() -> tuple[str, dict[str, dict[str, str]]]:
    """(version of clang-tidy, {source: its entry of compile_commands.json})."""
    build("debug")
    if not shutil.which("clang-tidy"):
        raise Broken("clang-tidy is not installed")
    version = subprocess.run(
        ["clang-tidy", "--version"], text=True, stdout=subprocess.PIPE, check=True
    ).stdout
    commands = json.loads((BUILD / "debug/compile_commands.json").read_text())
    return version, {os.path.relpath(entry["file"], ROOT): entry for entry in commands}


def clang_tidy(share: int, shares: int) -> Tally:
    """Checks each source whose content, headers, settings or command line have changed since it
    last passed.
    """
    version, entries = tidy_entries()
    cache, tally = result_cache.ResultCache(BUILD / "cache/tidy"), Tally()
    for source in sorted(set(entries).intersection(sources(".c")))[share::shares]:
        settings = sorted(
            path
            for folder in Path(ROOT, source).parents
            if folder.is_relative_to(ROOT)
            for path in folder.glob(".clang-tidy")
        )
        read = [*settings, *result_cache.compiled_from(entries[source])]
        key = result_cache.content_key(version, entries[source]["command"], *read)
        if cache.cases(key):
            tally.passed += 1
            continue
        log = f"tidy-{source.replace('/', '-')}.log"
        result = tool("clang-tidy", "--quiet", "-p", "build/debug", source, log=log)
        if not result.failed:
            cache.store(key)
        tally.add(result)
    tally.cached = cache.hits
    return tally


def cppcheck() -> Tally:
    return tool(
        "cppcheck",
        "--quiet",
        "--error-exitcode=1",
        "--std=c11",
        "--inline-suppr",
        f"-j{JOBS}",
        "--enable=warning,style,performance,portability",
        "--suppressions-list=cmake/cppcheck.txt",
        "-Ilib/include",
        "-Iport/include",
        "-Iport/node",
        "-Iport/wire",
        "-Ihost_sim",
        "lib/src",
        "port",
        "host_sim",
        "gateway",
        "python",
    )


def misra(page: str) -> Tally:
    """The violations of MISRA C:2012 in lib/ that cppcheck's addon finds are those that a page
    lists, by number of places for each rule.
    """
    made = BUILD / "misra"  # its files would be next to the sources, where other checks read
    shutil.rmtree(made, ignore_errors=True)
    made.mkdir(parents=True)
    words = "--quiet --std=c11 --platform=unix64 --addon=misra --enable=style --max-configs=1"
    command = ["cppcheck", *words.split(), f"-j{JOBS}", "--template={file}:{line}: {id}"]
    command.append(f"--cppcheck-build-dir={made}")
    status, output = run([*command, "-Ilib/include", "-Ilib/src", "lib/src"], "misra.log")
    places = sorted(line for line in set(output.splitlines()) if "misra-c2012-" in line)
    found = Counter(line.rsplit("-", 1)[1] for line in places)
    text = (ROOT / page).read_text(encoding="utf-8")
    table = re.findall(r"^\| (\d+\.\d+) \| \w+ \| (\d+) \|", text, re.MULTILINE)
    listed = Counter({rule: int(count) for rule, count in table})
    lines = [
        f"MISRA rule {rule}: {found[rule]} places, {listed[rule]} in {page} (misra.log)"
        for rule in sorted(found.keys() | listed.keys())
        if found[rule] != listed[rule]
    ]
    return Tally(failed=1, lines=lines) if status or lines or not found else Tally(passed=1)


def shell() -> Tally:
    scripts = [
        str(path.relative_to(ROOT))
        for path in [*(ROOT / "tools").rglob("*"), ROOT / ".ci/run"]
        if path.is_file()
        and (path.suffix == ".sh" or path.read_bytes().startswith(b"#!/usr/bin/env bash"))
    ]
    return tool("shellcheck", "--external-sources", "--source-path=SCRIPTDIR", *sorted(scripts))


def python_linter(name: str, *words: str, log: str) -> Tally:
    """Runs a program of build/venv-lint."""
    python = environment("lint", "tools/requirements-lint.txt")
    return tool(str(Path(python).with_name(name)), *words, log=log)


def ruff(verb: str, *options: str) -> Tally:
    return python_linter("ruff", verb, *options, log=f"ruff-{verb}.log")


def mypy() -> Tally:
    """Checks types, those of the packages that the lab's Python has included."""
    python = environment("lab", "tools/requirements-lab.txt")
    return python_linter("mypy", "--python-executable", python, log="mypy.log")
