"""Builds the C code of davar in each way and runs its suites: ctest, coverage, fuzz targets and
mutants. Standard library only.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import threading
import xml.etree.ElementTree
from collections import defaultdict
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from pathlib import Path

import coverage_report
import mcdc_report
import result_cache
from runner import BUILD, JOBS, LOGS, ROOT, Broken, Tally, once, run, tool

# ctest labels that a kind of build excludes. Tests labelled `long` measure statistics or count to
# 10^7; their results cannot depend on the kind of build.
LEFT_OUT = {"debug": "long", "sanitize": "long", "coverage": "long", "m32": "long", "mcdc": "long"}
TURN: defaultdict[str, threading.Lock] = defaultdict(
    threading.Lock
)  # one build at a time in each folder

# Target of tests/fuzz: (runs, longest input). The limit is a number of runs, not of seconds,
# because the inputs tried must not depend on the machine.
FUZZ = {
    "stream": (600, 400),
    "tracked": (1500, 160),
    "calls": (20_000, 400),
    "fits": (1500, 600),
    "cascades": (2000, 200),
    "selections": (2000, 200),
    "messages": (10_000, 600),
    "state": (4000, 64),
    "codec": (400_000, 128),
    "source": (4000, 9000),
    "recording": (40_000, 300),
    "options": (200_000, 300),
}


def use_ccache(variables: MutableMapping[str, str]) -> None:
    """Lets every build by CMake share its objects through ccache, also with other clones."""
    if shutil.which("ccache"):
        variables.setdefault("CMAKE_C_COMPILER_LAUNCHER", "ccache")
        variables.setdefault("CCACHE_BASEDIR", str(ROOT))  # paths below it do not count
        variables.setdefault("CCACHE_NOHASHDIR", "1")  # nor does the folder of the build


def must_run(what: str, log: str, command: Sequence[str]) -> None:
    status, output = run(command, log)
    if status:
        raise Broken(f"{what} failed:\n{output}")


@once
def configure(preset: str) -> None:
    unity = os.environ.get("DAVAR_UNITY_DIR", "")
    must_run(
        f"configure {preset}",
        f"configure-{preset}.log",
        ["cmake", "--preset", preset, f"-DDAVAR_UNITY_DIR={unity}"],
    )


@once
def build(preset: str, target: str = "all") -> None:
    """Configures and builds a target of a preset (both are quick when nothing changed)."""
    with TURN[preset]:
        configure(preset)
        must_run(
            f"build {preset}",
            f"build-{preset}.log",
            ["cmake", "--build", "--preset", preset, "--parallel", JOBS, "--target", target],
        )


def program(name: str, preset: str) -> str:
    """The path of a program. Builds only this program."""
    build(preset, Path(name).name)
    return str(BUILD / preset / name)


def unity_tally(name: str, output: str, status: str | None) -> Tally:
    """Counts the cases of one Unity program; a program that prints no summary is one case."""
    summary = re.search(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", output, re.MULTILINE)
    if not summary:
        return (
            Tally(passed=1)
            if status == "run"
            else Tally(failed=1, lines=[f"FAILED {name}:\n{output}"])
        )
    tests, failures, ignored = map(int, summary.groups())
    lines = [f"skipped: {name}: {case}" for case in re.findall(r":(test\w*:IGNORE.*)", output)]
    if status != "run" or failures:
        failures = max(failures, 1)
        lines.append(f"FAILED {name}:\n{output}")
    return Tally(tests - failures - ignored, failures, ignored, lines)


def cache_keys(preset: str, chosen: Sequence[str]) -> dict[str, str]:
    """{test: key of its program}, for tests that read nothing: their results depend on their own
    bytes and the C library's.
    """
    if "DAVAR_TEST_SEED" in os.environ:
        return {}
    listed = subprocess.run(
        ["ctest", "--preset", preset, "--show-only=json-v1", *chosen],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    tests = json.loads(listed[listed.index("{") :])["tests"]
    return {
        test["name"]: result_cache.content_key(
            os.confstr("CS_GNU_LIBC_VERSION"), Path(test["command"][0])
        )
        for test in tests
        if len(test["command"]) == 1
        and "ENVIRONMENT" not in (one["name"] for one in test["properties"])
    }


def ctest(preset: str, variables: Mapping[str, str] | None = None) -> Tally:
    """Runs the suites of a build, except those with a cached result. Builds that measure coverage
    run them all.
    """
    build(preset)
    chosen = ["--label-exclude", LEFT_OUT[preset]] if preset in LEFT_OUT else []
    cache, tally = result_cache.ResultCache(BUILD / "cache/ctest"), Tally()
    keys = {} if preset in ("coverage", "mcdc") else cache_keys(preset, chosen)
    cached = {name: cases for name, key in keys.items() if (cases := cache.cases(key))}
    tally.passed, tally.cached = sum(cached.values()), cache.hits
    chosen += ["--exclude-regex", f"^({'|'.join(cached)})$"] if cached else []
    report = LOGS / f"ctest-{preset}.xml"
    report.unlink(missing_ok=True)
    status, output = run(
        [
            "ctest",
            "--preset",
            preset,
            "--parallel",
            JOBS,
            "--output-junit",
            str(report),
            "--test-output-size-passed",
            "1000000",
            "--test-output-size-failed",
            "1000000",
            *chosen,
        ],
        f"ctest-{preset}.log",
        {**os.environ, **(variables or {})},
    )
    if not report.exists():
        if status or not cached:
            raise Broken(output)
        return tally  # every suite was cached
    for case in xml.etree.ElementTree.parse(report).iter("testcase"):
        name = case.get("name", "")
        result = unity_tally(name, case.findtext("system-out") or "", case.get("status"))
        if name in keys and result.passed and not result.failed + result.skipped:
            cache.store(keys[name], result.passed)
        tally.add(result)
    if status and not tally.failed:
        raise Broken(output)
    return tally


def checked(tally: Tally, summary: str, missing: Sequence[str]) -> Tally:
    """`tally` with one more case, which passed if nothing is missing."""
    tally.add(Tally(failed=1, lines=missing) if missing else Tally(passed=1))
    tally.lines.append(summary)
    return tally


def coverage() -> Tally:
    """Every line and branch of lib/ must have run, except the listed exceptions."""
    for old in (BUILD / "coverage").rglob("*.gcda"):
        old.unlink()
    tally = ctest("coverage")
    report = LOGS / "coverage.json"
    must_run(
        "gcovr",
        "gcovr.log",
        [
            "gcovr",
            "--root",
            ".",
            "--filter",
            "lib/",
            "--filter",
            "port/wire/",
            "--exclude-unreachable-branches",
            "--exclude-directories",
            ".*test_assert.*",
            "--json",
            str(report),
            "build/coverage",
        ],
    )
    return checked(tally, *coverage_report.missing(report, ROOT / "tests/coverage_exceptions.txt"))


def mcdc() -> Tally:
    """Every condition of lib/ must have decided the outcome of its decision alone, except the
    listed exceptions.
    """
    profiles = BUILD / "mcdc/profiles"
    shutil.rmtree(profiles, ignore_errors=True)
    tally = ctest("mcdc", {"LLVM_PROFILE_FILE": str(profiles / "%p.profraw")})
    profile = BUILD / "mcdc/profile"
    programs = [
        path
        for path in sorted((BUILD / "mcdc/tests").glob("test_*"))
        if path.is_file() and os.access(path, os.X_OK) and path.name != "test_assert"
    ]
    tool(
        "llvm-profdata-19",
        "merge",
        "-o",
        str(profile),
        *map(str, sorted(profiles.iterdir())),
        log="mcdc-merge.log",
    ).must()
    report = subprocess.run(
        [
            "llvm-cov-19",
            "export",
            "-instr-profile",
            str(profile),
            *(f"-object={path}" for path in programs),
        ],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    if report.returncode:
        raise Broken("llvm-cov-19 export failed")
    return checked(tally, *mcdc_report.missing(report.stdout, ROOT))


def fuzz(name: str) -> Tally:
    """Runs one target on its corpus, then a fixed number of times from a seed. A failure leaves its
    input in build/log.
    """
    runs, longest = FUZZ[name]
    target, corpus = program(f"tests/fuzz/fuzz_{name}", "fuzz"), BUILD / f"fuzz/corpus/{name}"
    must_run(
        "unpacking the corpus",
        f"fuzz-{name}-corpus.log",
        [sys.executable, "-B", "tests/fuzz/corpus.py", "unpack", name],
    )
    found = BUILD / f"fuzz/found-{name}"  # libFuzzer adds new inputs to its first folder
    shutil.rmtree(found, ignore_errors=True)
    found.mkdir()
    crash = LOGS / f"fuzz-{name}-"
    status, output = run(
        [
            target,
            "-seed=1",
            f"-runs={runs}",
            f"-max_len={longest}",
            f"-artifact_prefix={crash}",
            str(found),
            str(corpus),
        ],
        f"fuzz-{name}.log",
    )
    done = re.search(r"^Done (\d+) runs", output, re.MULTILINE)
    return Tally(passed=1) if status == 0 and done else Tally(failed=1, lines=[output[-4000:]])


def sources(*suffixes: str) -> list[str]:
    """All files with these suffixes in folders with C code, relative to the root."""
    folders = ("lib", "port", "host_sim", "gateway", "examples", "python", "tests")
    return sorted(
        str(path.relative_to(ROOT))
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.suffix in suffixes
    )


def mutants(python: Callable[[], str]) -> Tally:
    """Sixty small faults in lib/, the same every time. A suite must find each of them, or a list
    must contain it with a reason. The result is cached until a source, a build file or the compiler
    changes. python() returns the Python for this.
    """
    command = ["tests/mutation/mutants.py", "--sample", "60", "--unlisted"]
    cache = result_cache.ResultCache(BUILD / "cache/mutants")
    compiler = subprocess.run(
        ["cc", "--version"], text=True, stdout=subprocess.PIPE, check=True
    ).stdout
    key = result_cache.content_key(
        *command,
        compiler,
        *(ROOT / name for name in sources(".c", ".h", ".inc", ".txt", ".cmake")),
        *sorted(ROOT.glob("cmake/*")),
        *sorted(ROOT.glob("tests/mutation/*.py")),
        ROOT / "CMakeLists.txt",
        ROOT / "tools/support/requirements-mutants.txt",
    )
    if cases := cache.cases(key):
        tally = Tally(cases)
        tally.cached = cases
        return tally
    status, output = run([python(), "-B", *command], "mutants.log")
    done = re.search(
        r"^(\d+) mutants tested, (\d+) neither killed nor listed, (\d+) listed",
        output,
        re.MULTILINE,
    )
    if not done:
        raise Broken(output)
    tried, alive, stale = map(int, done.groups())
    if not status:
        cache.store(key, tried - alive)
    return Tally(tried - alive, alive + stale, 0, [output] if status else [])
