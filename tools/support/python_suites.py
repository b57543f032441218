"""Runs the Python suites of tests/ and makes the environments that they need. Standard library
only.
"""

import atexit
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from c_suites import program
from runner import BUILD, ROOT, Broken, Tally, once, run, tool

# The command line of a Python, and variables for its environment.
Python = tuple[list[str], dict[str, str]]
Setting = Callable[[], Python]
# Seconds of real time after which a guest counts as hung, however busy the machine is.
HANG_S = "1800"


def plain() -> Python:
    return [sys.executable], {}


def suite(
    part: str,
    folder: str | None = None,
    setting: Setting = plain,
    shared: Mapping[str, int] | None = None,
) -> list[partial[Tally]]:
    """The unittest modules of tests/<folder>, one job each, or several jobs as given by `shared`
    {module: jobs}. setting() builds their requirements.
    """
    folder, shared = f"tests/{folder or part}", shared or {}
    return [
        partial(python_module, part, folder, path.name, setting, share)
        for path in sorted((ROOT / folder).glob("test_*.py"))
        for share in shares(shared.get(path.name, 1))
    ]


def shares(count: int) -> list[str]:
    return [f"{share}/{count}" for share in range(1, count + 1)]


def python_module(
    part: str,
    folder: str,
    name: str,
    setting: Setting,
    share: str = "1/1",
    cases: str | None = None,
) -> Tally:
    """Runs a unittest module, or one share of it, or the cases whose name contains `cases`."""
    command, variables = setting()
    log = f"{part}-{Path(name).stem}{'' if share == '1/1' else '-' + share.split('/')[0]}.log"
    words = (
        ["-m", "unittest", "discover", "-v", "-s", folder, "-p", name]
        if share == "1/1"
        else ["tools/support/share.py", share, folder, name]
    )
    words += ["-k", cases] if cases else []
    status, output = run([*command, "-B", *words], log, {**os.environ, **variables})
    ran = re.search(r"^Ran (\d+) test", output, re.MULTILINE)
    if not ran:
        raise Broken(output)
    counts = {
        key: int(value) for key, value in re.findall(r"(failures|errors|skipped)=(\d+)", output)
    }
    failed, skipped = counts.get("failures", 0) + counts.get("errors", 0), counts.get("skipped", 0)
    failed = max(failed, 1) if status or int(ran.group(1)) + skipped == 0 else failed
    lines = [
        f"skipped: {line}" for line in output.splitlines() if re.search(r" \.\.\. skipped ", line)
    ]
    tally = Tally(
        max(int(ran.group(1)) - failed - skipped, 0),
        failed,
        skipped,
        lines + ([output] if failed else []),
    )
    tally.cached = sum(map(int, re.findall(r"^cached: (\d+)$", output, re.MULTILINE)))
    return tally


@once
def set_up(words: str, log: str) -> str:
    """Runs functions of tools/support/setup.sh and returns the last line printed, if any."""
    status, output = run(["bash", "-c", f". tools/support/setup.sh && {words}"], log)
    if status:
        raise Broken(output)
    return (output.splitlines() or [""])[-1]


def environment(name: str, requirements: str | None = None) -> str:
    """The Python of build/venv-NAME, with the pins of requirements-NAME.txt."""
    requirements = requirements or f"tools/support/requirements-{name}.txt"
    return set_up(f"python_environment venv-{name} {requirements}", f"{name}-python.log")


def simulator(preset: str) -> Python:
    return [sys.executable], {
        "DAVAR_SIM": program("host_sim/davar-sim", preset),
        "DAVAR_SETTINGS_PROBE": program("tests/settings_probe", preset),
    }


DAVARLAB = {"PYTHONPATH": str(ROOT / "tools/lab")}  # for modules that import davarlab


def lab() -> Python:
    """The lab's own Python, for modules that import the lab. Also builds what the commands in
    tools/ build on their first use, because all modules would otherwise find it missing at the same
    time.
    """
    set_up("build tools && build tools davar_lab", "tools.log")
    return [environment("lab", "tools/requirements-lab.txt")], {
        "DAVAR_LAB_LIBRARY": str(BUILD / "tools/tools/lab/libdavar_lab.so"),
        "OPENBLAS_NUM_THREADS": "1",
        **DAVARLAB,
    }


def lab_with(name: str) -> Python:
    """The lab's Python with the pins of requirements-NAME.txt added."""
    extra = environment(name)
    command, variables = lab()
    return command, {
        **variables,
        "PYTHONPATH": str(next(Path(extra).parents[1].glob("lib/python3*/site-packages"))),
        "DAVAR_SIM": str(BUILD / "tools/host_sim/davar-sim"),
    }


def hypothesis() -> Python:
    """The lab's Python with Hypothesis added."""
    return lab_with("hypothesis")


def readers() -> Python:
    """The lab's Python with pandas and the library of MCAP added."""
    return lab_with("readers")


def workbench() -> Python:
    """Playwright, which drives Debian's chromium."""
    lab()
    return [environment("browser")], {}


def wire() -> Python:
    return [environment("wire")], {
        **DAVARLAB,
        "DAVAR_WIRE_PROBE": program("tests/wire_probe", "release"),
        "DAVAR_TELEMETRY_PROBE": program("tests/telemetry_probe", "release"),
        "DAVAR_NODE": program("gateway/davar-node", "release"),
        **simulator("release")[1],
    }


def betaflight() -> Python:
    """yamspy and pymavlink, which read the telemetry of a flight controller."""
    return [environment("betaflight")], {}


@once
def package() -> Python:
    """Builds the sdist and the wheel of the Python package, and installs the wheel into a Python
    outside the checkout, together with AllanTools, pytest for its tests, Hypothesis and the filter
    of an example.
    """
    set_up("build tools davar-sim", "package-sim.log")
    maker = environment("package")
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    dist, python = Path(folder.name, "dist"), f"{folder.name}/python/bin/python"
    pip = [python, "-m", "pip", "install", "--disable-pip-version-check"]
    for log, command in {
        "make": [maker, "-m", "build", "--outdir", str(dist), "."],
        "venv": [sys.executable, "-m", "venv", f"{folder.name}/python"],
        "beside": [
            *pip,
            "--no-deps",
            "-r",
            "tools/requirements-bench.txt",
            "-r",
            "tools/support/requirements-hypothesis.txt",
            "-r",
            "examples/ahrs_flight/requirements.txt",
            "-r",
            "tools/support/requirements-allantools.txt",
        ],
    }.items():
        tool(*command, log=f"package-{log}.log").must()
    Path(folder.name, "home").mkdir()
    tool(*pip, *map(str, dist.glob("*.whl")), log="package-install.log").must()
    return [python], {
        "DAVAR_DIST": str(dist),
        "DAVAR_MYPY": maker,
        "DAVAR_ALLANTOOLS_TESTS": tests_of_allantools(python, Path(folder.name)),
        "DAVAR_SIM": str(BUILD / "tools/host_sim/davar-sim"),
        "DAVAR_LAB_PYTHON": lab()[0][0],
        "HOME": str(Path(folder.name, "home")),
    }


def tests_of_allantools(python: str, folder: Path) -> str:
    """Unpacks AllanTools' tests, which only its source distribution contains, in a folder. Returns
    their path, or "" if pip cannot download them.
    """
    pins = (ROOT / "tools/requirements-bench.txt").read_text().splitlines()
    pin = next(line for line in pins if line.startswith("AllanTools=="))
    kept = BUILD / pin
    if not list(kept.glob("*.tar.gz")):
        pip = [python, "-m", "pip", "download", "--no-deps", "--no-binary", ":all:"]
        if tool(*pip, "--dest", str(kept), pin, log="package-allantools.log").failed:
            return ""
    tool("tar", "-xzf", *map(str, kept.glob("*.tar.gz")), "-C", str(folder)).must()
    return str(next(folder.glob("allantools-*/tests")))


@once
def commands() -> Python:
    """Makes everything that the commands of the pages make on their first use. The clone in which
    they run shares it.
    """
    set_up("python_environment venv tools/requirements.txt", "demo-python.log")
    environment("bench", "tools/requirements-bench.txt")
    environment("packages")
    return lab()


@once
def packages() -> Python:
    """Makes a draft of a release, and a Python with the packaging tools of each ecosystem."""
    python = environment("packages")
    folder = BUILD / "release-test"
    shutil.rmtree(folder, ignore_errors=True)
    status, output = run(["tools/release", "--draft", "--out", str(folder)], "release.log")
    if status:
        raise Broken(output)
    return [python], {"DAVAR_RELEASE": str(folder)}


@once
def linux() -> str:
    """The User-Mode Linux kernel of tests/kernel, shared by all clones; built if there is none."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "davar/uml")
    status, output = run(["tools/support/uml/kernel.sh", str(cache)], "uml.log")
    if status:
        raise Broken(output)
    return output.splitlines()[-1]


def guest() -> Python:
    """A User-Mode Linux kernel in virtual time."""
    lab()  # files that the guest makes are lost when it ends
    command, variables = wire()
    variables["PATH"] = f"{Path(command[0]).parent}:{os.environ['PATH']}"
    variables["DAVAR_SEEN"] = os.environ.get("DAVAR_SEEN", "")
    return [
        "tools/support/uml/run",
        "-T",
        "-t",
        HANG_S,
        linux(),
        "env",
        *(f"{name}={value}" for name, value in variables.items()),
        *command,
    ], {}


def board() -> Python:
    """An emulated board connected to such a kernel."""
    return [environment("wire")], {"DAVAR_KERNEL": linux(), **DAVARLAB, **simulator("release")[1]}


def reference() -> Python:
    """pdoc, which imports python/davar; that needs numpy, but not the library."""
    return [environment("reference", "tools/requirements-reference.txt")], {
        "PYTHONPATH": str(ROOT / "python")
    }
