"""The parts of tools/test: each builds what it needs, runs a tool or a test suite and returns a tally.

A part is a list of jobs, which do not depend on each other; run_parts() runs two more at once than there are cores. Called by
tools/test, which has seen to the packages and to Unity. Standard library only.
"""

import argparse
import atexit
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import xml.etree.ElementTree
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from functools import partial
from pathlib import Path

import coverage_report
import mcdc_report
import remembered
import targets

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
LOGS = BUILD / "log"
JOBS = str(os.cpu_count() or 2)
HANG_S = "1800"  # real seconds after which a guest is thought to hang, however busy the machine is
# ctest labels that a kind of build leaves out: these tests measure statistics or count to 10^7, and their answer cannot
# depend on the kind of build.
LEFT_OUT = {"debug": "long", "sanitize": "long", "coverage": "long", "m32": "long", "mcdc": "long"}


class Tally:
    """Counts of one part; `lines` are what a person must read (failures, names of skipped tests)."""

    def __init__(self, passed=0, failed=0, skipped=0, lines=()):
        self.passed, self.failed, self.skipped, self.lines = passed, failed, skipped, list(lines)
        self.known = 0  # answers that were remembered

    def add(self, other):
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.lines += other.lines
        self.known += other.known

    def must(self):
        """Nothing failed, or there is no going on."""
        if self.failed:
            raise Broken("\n".join(self.lines))

    def __str__(self):
        return f"{self.passed} passed, {self.failed} failed, {self.skipped} skipped" + (f", {self.known} answers known" if self.known else "")


class Broken(Exception):
    """A part that could not run: a build that fails, a tool that is missing."""


def run(command, log, env=None):
    """Runs a command with its output in build/log; returns (exit status, output)."""
    done = subprocess.run(command, cwd=ROOT, env=env, text=True, errors="replace",
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    (LOGS / log).write_text(done.stdout)
    return done.returncode, done.stdout


def once(work):
    """`work`, done once for each argument: whoever comes second waits for the first, and gets its result or its failure."""
    done, lock = {}, threading.Lock()

    def result(*key):
        with lock:
            first = key not in done
            future = done.setdefault(key, Future())
        if first:
            try:
                future.set_result(work(*key))
            except BaseException as why:
                future.set_exception(why)
        return future.result()

    return result


@once
def build(preset):
    """Configures and builds a preset (both are quick when nothing changed)."""
    unity = os.environ.get("DAVAR_UNITY_DIR", "")
    steps = (["cmake", "--preset", preset, f"-DDAVAR_UNITY_DIR={unity}"],
             ["cmake", "--build", "--preset", preset, "--parallel", JOBS])
    for step, command in zip(("configure", "build"), steps):
        status, output = run(command, f"{step}-{preset}.log")
        if status:
            raise Broken(f"{step} {preset} failed:\n{output}")


def program(name, preset):
    build(preset)
    return str(BUILD / preset / name)


def unity_tally(name, output, status):
    """Counts the cases of one Unity program; a program that prints no summary is one case."""
    summary = re.search(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", output, re.MULTILINE)
    if not summary:
        return Tally(passed=1) if status == "run" else Tally(failed=1, lines=[f"FAILED {name}:\n{output}"])
    tests, failures, ignored = map(int, summary.groups())
    lines = [f"skipped: {name}: {case}" for case in re.findall(r":(test\w*:IGNORE.*)", output)]
    if status != "run" or failures:
        failures = max(failures, 1)
        lines.append(f"FAILED {name}:\n{output}")
    return Tally(tests - failures - ignored, failures, ignored, lines)


def alone(preset, chosen):
    """{test: key of its program}, of those that read nothing: what they say depends on their bytes alone, and on the C library's."""
    if "DAVAR_TEST_SEED" in os.environ:
        return {}
    listed = subprocess.run(["ctest", "--preset", preset, "--show-only=json-v1", *chosen], cwd=ROOT, text=True, stdout=subprocess.PIPE, check=True).stdout
    tests = json.loads(listed[listed.index("{"):])["tests"]
    return {test["name"]: remembered.content_key(os.confstr("CS_GNU_LIBC_VERSION"), Path(test["command"][0])) for test in tests
            if len(test["command"]) == 1 and "ENVIRONMENT" not in (one["name"] for one in test["properties"])}


def ctest(preset, variables=None):
    """The suites of a build. Those that passed are known; but where the run itself is looked at, for coverage, all run."""
    build(preset)
    chosen = ["--label-exclude", LEFT_OUT[preset]] if preset in LEFT_OUT else []
    passed, tally = remembered.Passed(BUILD / "cache/ctest"), Tally()
    keys = {} if preset in ("coverage", "mcdc") else alone(preset, chosen)
    known = {name: cases for name, key in keys.items() if (cases := passed.cases(key))}
    tally.passed, tally.known = sum(known.values()), passed.known
    chosen += ["--exclude-regex", f"^({'|'.join(known)})$"] if known else []
    report = LOGS / f"ctest-{preset}.xml"
    report.unlink(missing_ok=True)
    status, output = run(["ctest", "--preset", preset, "--parallel", JOBS, "--output-junit", str(report), "--test-output-size-passed", "1000000",
                          "--test-output-size-failed", "1000000", *chosen], f"ctest-{preset}.log", {**os.environ, **(variables or {})})
    if not report.exists():
        if status or not known:
            raise Broken(output)
        return tally  # nothing was left to ask
    for case in xml.etree.ElementTree.parse(report).iter("testcase"):
        name = case.get("name")
        answer = unity_tally(name, case.findtext("system-out") or "", case.get("status"))
        if name in keys and answer.passed and not answer.failed + answer.skipped:
            passed.keep(keys[name], answer.passed)
        tally.add(answer)
    if status and not tally.failed:
        raise Broken(output)
    return tally


def coverage():
    for old in (BUILD / "coverage").rglob("*.gcda"):
        old.unlink()
    tally = ctest("coverage")
    report = LOGS / "coverage.json"
    status, output = run(["gcovr", "--root", ".", "--filter", "lib/", "--exclude-unreachable-branches",
                          "--exclude-directories", ".*test_assert.*", "--json",
                          str(report), "build/coverage"], "gcovr.log")
    if status:
        raise Broken(output)
    summary, missing = coverage_report.missing(report, ROOT / "tests/coverage_exceptions.txt")
    tally.add(Tally(failed=1, lines=missing) if missing else Tally(passed=1))
    tally.lines.append(summary)
    return tally


def mcdc():
    """Each condition of a decision of lib/ must have turned it alone, but for the named exceptions."""
    profiles = BUILD / "mcdc/profiles"
    shutil.rmtree(profiles, ignore_errors=True)
    tally = ctest("mcdc", {"LLVM_PROFILE_FILE": str(profiles / "%p.profraw")})
    profile = BUILD / "mcdc/profile"
    programs = [path for path in sorted((BUILD / "mcdc/tests").glob("test_*"))
                if path.is_file() and os.access(path, os.X_OK) and path.name != "test_assert"]
    tool("llvm-profdata-19", "merge", "-o", str(profile), *map(str, sorted(profiles.iterdir())), log="mcdc-merge.log").must()
    report = subprocess.run(["llvm-cov-19", "export", "-instr-profile", str(profile), *(f"-object={path}" for path in programs)],
                            cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    if report.returncode:
        raise Broken("llvm-cov-19 export failed")
    summary, missing = mcdc_report.missing(report.stdout, ROOT, ROOT / "tests/mcdc_exceptions.txt")
    tally.add(Tally(failed=1, lines=missing) if missing else Tally(passed=1))
    tally.lines.append(summary)
    return tally


def tool(*command, log=None):
    """One outside tool is one test: it finds nothing, or it fails."""
    if not shutil.which(command[0]):
        raise Broken(f"{command[0]} is not installed")
    status, output = run(list(command), log or f"{Path(command[0]).name}.log")
    return Tally(failed=1, lines=[output]) if status else Tally(passed=1)


def sources(*suffixes):
    folders = ("lib", "port", "host_sim", "gateway", "examples", "python", "tests")
    return sorted(str(path.relative_to(ROOT)) for folder in folders for path in (ROOT / folder).rglob("*")
                  if path.suffix in suffixes)


@once
def tidy_entries():
    """(what every answer depends on, {source: its entry of compile_commands.json})."""
    build("debug")
    if not shutil.which("clang-tidy"):
        raise Broken("clang-tidy is not installed")
    version = subprocess.run(["clang-tidy", "--version"], text=True, stdout=subprocess.PIPE, check=True).stdout
    commands = json.loads((BUILD / "debug/compile_commands.json").read_text())
    return version, {os.path.relpath(entry["file"], ROOT): entry for entry in commands}


def clang_tidy(share, shares):
    """Each source whose content, headers, settings or compiler's command line changed since it passed."""
    version, entries = tidy_entries()
    passed, tally = remembered.Passed(BUILD / "cache/tidy"), Tally()
    for source in sorted(set(entries).intersection(sources(".c")))[share::shares]:
        entry, answer = entries[source], Tally(passed=1)

        def check():
            answer.passed = 0
            answer.add(tool("clang-tidy", "--quiet", "-p", "build/debug", source, log=f"tidy-{source.replace('/', '-')}.log"))
            return not answer.failed

        settings = sorted(path for folder in Path(ROOT, source).parents if folder.is_relative_to(ROOT)
                          for path in folder.glob(".clang-tidy"))
        passed.check(remembered.content_key(version, entry["command"], *settings, *remembered.compiled_from(entry)), check)
        tally.add(answer)
    tally.known = passed.known
    return tally


def cppcheck():
    return tool("cppcheck", "--quiet", "--error-exitcode=1", "--std=c11", "--inline-suppr", f"-j{JOBS}",
                "--enable=warning,style,performance,portability", "--suppressions-list=cmake/cppcheck.txt",
                "-Ilib/include", "-Iport/include", "-Iport/node", "-Ihost_sim", "lib/src", "port", "host_sim", "gateway", "python")


def shell():
    scripts = [str(path.relative_to(ROOT)) for path in [*(ROOT / "tools").rglob("*"), ROOT / ".ci/run"]
               if path.is_file() and (path.suffix == ".sh" or path.read_bytes().startswith(b"#!/usr/bin/env bash"))]
    return tool("shellcheck", "--external-sources", "--source-path=SCRIPTDIR", *sorted(scripts))


def plain():
    return [sys.executable], {}


def suite(part, folder=None, setting=plain, shared=None):
    """The unittest modules of tests/<folder>, a job each, or as many as `shared` {module: jobs} says. setting(): builds what
    they need; the command that a Python ends, and variables for its environment."""
    folder, shared = f"tests/{folder or part}", shared or {}
    return [partial(python_module, part, folder, path.name, setting, share) for path in sorted((ROOT / folder).glob("test_*.py"))
            for share in shares(shared.get(path.name, 1))]


def shares(count):
    return [f"{share}/{count}" for share in range(1, count + 1)]


def python_module(part, folder, name, setting, share="1/1"):
    command, variables = setting()
    log = f"{part}-{Path(name).stem}{'' if share == '1/1' else '-' + share.split('/')[0]}.log"
    runner = ["-m", "unittest", "discover", "-v", "-s", folder, "-p", name] if share == "1/1" else ["tools/support/share.py", share, folder, name]
    status, output = run([*command, "-B", *runner], log, {**os.environ, **variables})
    ran = re.search(r"^Ran (\d+) test", output, re.MULTILINE)
    if not ran:
        raise Broken(output)
    counts = {key: int(value) for key, value in re.findall(r"(failures|errors|skipped)=(\d+)", output)}
    failed, skipped = counts.get("failures", 0) + counts.get("errors", 0), counts.get("skipped", 0)
    failed = max(failed, 1) if status or int(ran.group(1)) + skipped == 0 else failed
    lines = [f"skipped: {line}" for line in output.splitlines() if re.search(r" \.\.\. skipped ", line)]
    tally = Tally(max(int(ran.group(1)) - failed - skipped, 0), failed, skipped, lines + ([output] if failed else []))
    tally.known = sum(map(int, re.findall(r"^remembered: (\d+)$", output, re.MULTILINE)))
    return tally


@once
def set_up(words, log):
    """Runs functions of tools/support/setup.sh; the last line they print."""
    status, output = run(["bash", "-c", f". tools/support/setup.sh && {words}"], log)
    if status:
        raise Broken(output)
    return output.splitlines()[-1]


def simulator(preset):
    return [sys.executable], {"DAVAR_SIM": program("host_sim/davar-sim", preset)}


def wire_python():
    """The Python of build/venv-wire, made when missing or when the pins have changed."""
    return set_up("python_environment venv-wire tools/support/requirements-wire.txt", "wire-python.log")


def lab():
    """Makes what the commands in tools/ build on their first use, and every module would find missing at once. The lab's own
    Python, for the modules that look at its parts or call it without a process of its own."""
    python = set_up("build tools && build tools davar_lab && python_environment venv-lab tools/requirements-lab.txt", "tools.log")
    return [python], {"DAVAR_LAB_LIBRARY": str(BUILD / "tools/tools/lab/libdavar_lab.so"), "OPENBLAS_NUM_THREADS": "1",
                      "PYTHONPATH": str(ROOT / "tools/lab")}


def hypothesis():
    """The lab's Python with Hypothesis beside it."""
    extra = set_up("python_environment venv-hypothesis tools/support/requirements-hypothesis.txt", "hypothesis-python.log")
    command, variables = lab()
    return command, {**variables, "PYTHONPATH": str(next(Path(extra).parents[1].glob("lib/python3*/site-packages")))}


def workbench():
    """Playwright, which drives Debian's chromium."""
    lab()
    return [set_up("python_environment venv-browser tools/support/requirements-browser.txt", "browser-python.log")], {}


def wire():
    return [wire_python()], {"DAVAR_WIRE_PROBE": program("tests/wire_probe", "release"),
                             "DAVAR_NODE": program("gateway/davar-node", "release"), **simulator("release")[1]}


@once
def package():
    """Makes sdist and wheel of the Python package with the real tools, and installs the wheel where nothing else of the project is: into a
    Python outside of the checkout, with AllanTools and Hypothesis beside it."""
    maker = set_up("build tools davar-sim && python_environment venv-package tools/support/requirements-package.txt", "package-python.log")
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    dist, python = Path(folder.name, "dist"), f"{folder.name}/python/bin/python"
    pip = [python, "-m", "pip", "install", "--disable-pip-version-check"]
    for log, command in {"make": [maker, "-m", "build", "--outdir", str(dist), "."], "venv": [sys.executable, "-m", "venv", f"{folder.name}/python"],
                         "beside": [*pip, "--no-deps", "-r", "tools/requirements-bench.txt", "-r", "tools/support/requirements-hypothesis.txt"]}.items():
        tool(*command, log=f"package-{log}.log").must()
    Path(folder.name, "home").mkdir()
    tool(*pip, *map(str, dist.glob("*.whl")), log="package-install.log").must()
    return [python], {"DAVAR_DIST": str(dist), "DAVAR_MYPY": maker, "DAVAR_SIM": str(BUILD / "tools/host_sim/davar-sim"), "DAVAR_LAB_PYTHON": lab()[0][0],
                      "HOME": str(Path(folder.name, "home"))}


@once
def commands():
    """What the commands of the pages make on their first use is made here, and kept: their clone shares it."""
    set_up("python_environment venv tools/requirements.txt && python_environment venv-bench tools/requirements-bench.txt && "
           "python_environment venv-packages tools/support/requirements-packages.txt", "commands.log")
    return lab()


@once
def packages():
    """A release, a draft if the changes are not written yet, and a Python with the tools of the ecosystems."""
    python = set_up("python_environment venv-packages tools/support/requirements-packages.txt", "packages-python.log")
    folder = BUILD / "release-test"
    shutil.rmtree(folder, ignore_errors=True)
    status, output = run(["tools/release", "--draft", "--out", str(folder)], "release.log")
    if status:
        raise Broken(output)
    return [python], {"DAVAR_RELEASE": str(folder)}


@once
def linux():
    """The kernel of the tests of tests/kernel, built when the cache has none."""
    status, output = run(["tools/support/uml/kernel.sh", "build/cache/uml"], "uml.log")
    if status:
        raise Broken(output)
    return output.splitlines()[-1]


def guest():
    """A User-Mode Linux kernel in virtual time."""
    lab()  # the guest could not keep what it makes
    command, variables = wire()
    variables["PATH"] = f"{Path(command[0]).parent}:{os.environ['PATH']}"
    variables["DAVAR_SEEN"] = os.environ.get("DAVAR_SEEN", "")
    return ["tools/support/uml/run", "-T", "-t", HANG_S, linux(), "env",
            *(f"{name}={value}" for name, value in variables.items()), *command], {}


def board():
    """An emulated board beside such a kernel."""
    return [wire_python()], {"DAVAR_KERNEL": linux(), **simulator("release")[1]}


# Target of tests/fuzz: runs, and the longest input. Runs and not seconds: what is tried does not depend on the machine.
FUZZ = {"stream": (600, 400), "tracked": (1500, 160), "calls": (20_000, 400), "state": (4000, 64), "codec": (400_000, 128), "source": (4000, 9000),
        "recording": (40_000, 300), "options": (200_000, 300)}


def fuzz(name):
    """One target: its corpus, then a bounded number of runs from a seed. A failure leaves its input in build/log."""
    runs, longest = FUZZ[name]
    target, corpus = program(f"tests/fuzz/fuzz_{name}", "fuzz"), BUILD / f"fuzz/corpus/{name}"
    tool(sys.executable, "-B", "tests/fuzz/corpus.py", "unpack", name, log=f"fuzz-{name}-corpus.log").must()
    found = BUILD / f"fuzz/found-{name}"  # what the fuzzer keeps goes here, not into the tree
    shutil.rmtree(found, ignore_errors=True)
    found.mkdir()
    crash = LOGS / f"fuzz-{name}-"
    status, output = run([target, "-seed=1", f"-runs={runs}", f"-max_len={longest}", f"-artifact_prefix={crash}", str(found),
                          str(corpus)], f"fuzz-{name}.log")
    done = re.search(r"^Done (\d+) runs", output, re.MULTILINE)
    return Tally(passed=1) if status == 0 and done else Tally(failed=1, lines=[output[-4000:]])


def mutants():
    """A sample of small faults in lib/, the same every time: each must be found by a suite, or is listed with the reason. Known until
    a source, a build file or the compiler changes."""
    command = ["tests/mutation/mutants.py", "--sample", "60", "--longest", "5", "--unlisted"]
    passed = remembered.Passed(BUILD / "cache/mutants")
    compiler = subprocess.run(["cc", "--version"], text=True, stdout=subprocess.PIPE, check=True).stdout
    key = remembered.content_key(*command, compiler, *(ROOT / name for name in sources(".c", ".h", ".txt", ".cmake")), *sorted(ROOT.glob("cmake/*")),
                                 *sorted(ROOT.glob("tests/mutation/*.py")), ROOT / "CMakeLists.txt", ROOT / "tools/support/requirements-mutants.txt")
    if cases := passed.cases(key):
        tally = Tally(cases)
        tally.known = cases
        return tally
    python = set_up("python_environment venv-mutants tools/support/requirements-mutants.txt", "mutants-python.log")
    status, output = run([python, "-B", *command], "mutants.log")
    done = re.search(r"^(\d+) mutants asked, (\d+) neither killed nor listed, (\d+) listed", output, re.MULTILINE)
    if not done:
        raise Broken(output)
    asked, alive, stale = map(int, done.groups())
    if not status:
        passed.keep(key, asked - alive)
    return Tally(asked - alive, alive + stale, 0, [output] if status else [])


PARTS = {
    "debug": ("unit, property and published tests, assertions on", [partial(ctest, "debug")]),
    "release": ("the same and the long ones, as shipped", [partial(ctest, "release")]),
    "sanitize": ("the same under address and undefined-behaviour sanitizers", [partial(ctest, "sanitize")]),
    "m32": ("the same as a 32-bit program", [partial(ctest, "m32")]),
    "coverage": ("the same; every line and branch of lib/ must have run", [coverage]),
    "mcdc": ("the same, quick ones; every condition of lib/ must have turned its decision alone (MC/DC)", [mcdc]),
    "proofs": ("statements of tests/proofs, proved by Eva of Frama-C for all inputs", suite("proofs")),
    "cli": ("davar-sim through its command line",
            [*suite("cli", setting=partial(simulator, "release")),
             partial(python_module, "cli", "tests/tracking", "test_recordings.py", partial(simulator, "release"))]),
    "cli-sanitize": ("the same, under the sanitizers", suite("cli-sanitize", "cli", partial(simulator, "sanitize"))),
    "tools": ("the commands in tools/ and the bundled recording", suite("tools")),
    "commands": ("every command of the pages and of --help, as typed, in a fresh clone", suite("commands", setting=commands)),
    "wire": ("frames against davar.dbc, read by cantools; the receiver against a million faults", suite("wire", setting=wire)),
    "kernel": ("CAN, serial lines and gpio on a User-Mode Linux kernel (built once, minutes), faults included",
               suite("kernel", setting=guest) + suite("kernel", "kernel_board", board)),
    "lab": ("tools/davarlab on recordings with known truth", suite("lab", setting=lab)),
    "hypothesis": ("what davarlab reads, damaged and made up, against other readers", suite("hypothesis", setting=hypothesis)),
    "workbench": ("tools/davarlab open in a real browser", suite("workbench", setting=workbench)),
    "package": ("the Python package as pip installs it, outside of the checkout", suite("package", setting=package)),
    "targets": ("the suites of lib/ and its cost on ten emulated boards",
                suite("targets", "target", partial(simulator, "release"),
                      {"test_suites.py": len(targets.MACHINES) + 1, "test_mcu.py": 3})),
    "fuzz": ("libFuzzer targets of tests/fuzz, a bounded number of runs each", [partial(fuzz, name) for name in FUZZ]),
    "mutants": ("small faults in lib/, sixty of them, each found by a fast suite", [mutants]),
    "consumer": ("find_package and add_subdirectory from outside", suite("consumer")),
    "examples": ("the examples that run on this machine", suite("examples")),
    "packages": ("every package of tools/release with the tool of its ecosystem", suite("packages", setting=packages)),
    "style": ("the house rules: includes, no heap, function length, one version", suite("style")),
    "format": ("clang-format", [partial(tool, "clang-format", "--dry-run", "-Werror", *sources(".c", ".h"))]),
    "tidy": ("clang-tidy", [partial(clang_tidy, share, 8) for share in range(8)]),
    "cppcheck": ("cppcheck", [cppcheck]),
    "shell": ("shellcheck", [shell]),
}
# Seconds of the long jobs on a quiet core, for a tree that has not run them yet: the longest are begun first, and the short ones
# fill what is left at the end. How long a job took is remembered in build/log.
GUESS = {"commands": 250, "coverage": 150, "sanitize": 130, "release": 120, "m32": 60, "mcdc": 100, "debug": 60, "mutants": 100,
         "proofs tests/proofs test_proofs.py": 110, "consumer tests/consumer test_install.py": 110, "consumer tests/consumer test_options.py": 90,
         "consumer tests/consumer test_amalgamate.py": 80, "lab tests/lab test_lab.py": 150, "lab tests/lab test_awkward_input.py": 110,
         "kernel tests/kernel test_ten_hours.py": 130, "kernel tests/kernel test_can.py": 130, "kernel tests/kernel test_readme.py": 90,
         "kernel tests/kernel test_live.py": 90, "kernel tests/kernel test_gpio.py": 60, "kernel tests/kernel test_serial.py": 60,
         "targets tests/target test_cost.py": 95, "targets tests/target test_porting.py": 60, "lab tests/lab test_elsewhere.py": 80,
         # and any other job of a part
         "targets": 55, "kernel": 50, "lab": 50, "workbench": 50, "hypothesis": 40, "packages": 40, "package": 40, "fuzz": 30, "tidy": 20}


def named(part, job):
    """What a job is called in build/log/seconds.json."""
    words = [str(word) for word in job.args if isinstance(word, (str, int))] if isinstance(job, partial) else []
    return " ".join(word for word in dict.fromkeys([part, *words]) if word != "1/1")[:200]


def attempt(job):
    """(tally, seconds) of one job; a job that breaks is one failure."""
    start = time.monotonic()
    try:
        tally = job()
    except Exception as why:
        tally = Tally(failed=1, lines=[str(why) if isinstance(why, Broken) else traceback.format_exc()])
    return tally, time.monotonic() - start


def show(name, results):
    """Prints a part whole: its line, with the seconds of all its jobs, and what a person must read. Its tally."""
    tally = Tally()
    for one, _ in results:
        tally.add(one)
    print(f"{name:<13} {tally}  ({sum(seconds for _, seconds in results):.0f} s)", flush=True)
    for line in dict.fromkeys(tally.lines):  # a build that fails fails every job alike
        print("    " + line.rstrip().replace("\n", "\n    "), flush=True)
    return tally


def run_parts(parts, seconds=None):
    """Runs the jobs of these parts {name: jobs}, the longest first, and prints a part when its last job is done. Two jobs more
    than there are cores: some wait for a lock, a browser or a device's clock."""
    total, taken = Tally(), {}
    jobs = [(seconds.expected(named(part, job)) if seconds else 0, part, number) for part, them in parts.items() for number, job in enumerate(them)]
    futures = {part: [None] * len(them) for part, them in parts.items()}
    with ThreadPoolExecutor(int(JOBS) + 2) as pool:
        for _, part, number in sorted(jobs, key=lambda job: -job[0]):
            futures[part][number] = pool.submit(attempt, parts[part][number])
        try:
            for _ in as_completed(future for them in futures.values() for future in them):
                for part in [part for part, them in futures.items() if all(job.done() for job in them)]:
                    results = [job.result() for job in futures.pop(part)]
                    taken |= {named(part, job): round(spent, 1) for job, (_, spent) in zip(parts[part], results)}
                    total.add(show(part, results))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    if seconds:
        seconds.keep(taken)
    return total


def keep_objects(variables):
    """What is compiled once is not compiled again, in whatever build or temporary copy: ccache for all of CMake's."""
    if not shutil.which("ccache"):
        return
    variables.setdefault("CMAKE_C_COMPILER_LAUNCHER", "ccache")
    variables.setdefault("CCACHE_DIR", str(BUILD / "cache/ccache"))
    variables.setdefault("CCACHE_MAXSIZE", "1G")
    if not ROOT.is_relative_to(tempfile.gettempdir()):  # there only names of folders change
        variables.setdefault("CCACHE_BASEDIR", os.path.realpath(tempfile.gettempdir()))


def main():
    parser = argparse.ArgumentParser(prog="tools/test")
    parser.add_argument("--only", default="")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    if options.list:
        print("\n".join(f"{name:<13} {what}" for name, (what, _) in PARTS.items()))
        return 0
    names = [name for name in options.only.split(",") if name] or list(PARTS)
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        print(f"tools/test: unknown part: {', '.join(unknown)} (see --list)", file=sys.stderr)
        return 2
    real = ROOT.parent / "shared/data/real"
    if real.is_dir():
        os.environ.setdefault("DAVAR_REAL_DATA", str(real))
    LOGS.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a job has one core
    keep_objects(os.environ)
    total = run_parts({name: PARTS[name][1] for name in names}, remembered.Seconds(LOGS / "seconds.json", GUESS))
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main())
