"""What every test shares: the programs under test, the gear, results that are still valid, and the
order of a run.

tests/parts.toml lists the parts. A part is a folder of tests/, or a module in tests/ itself.
"""

import functools
import hashlib
import json
import os
import resource
import shutil
import signal
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TESTS, BUILD = ROOT / "tests", ROOT / "build"
PARTS = tomllib.loads((TESTS / "parts.toml").read_text(encoding="utf-8"))
STORE, COSTS, MEASURED = BUILD / "cache/results", TESTS / "costs.json", BUILD / "log/costs.json"
EVERYWHERE = ("tests/conftest.py", "pyproject.toml", "tools/requirements-test.txt")
# Set for a run, without influence on a result.
SILENT = ("DAVAR_AGAIN", "DAVAR_SEEN", "DAVAR_BUILT", "DAVAR_UNITY_DIR")

PROGRAMS = {
    "DAVAR_SIM": "debug/host_sim/davar-sim",
    "DAVAR_NODE": "debug/gateway/davar-node",
    "DAVAR_WIRE_PROBE": "debug/tests/wire_probe",
    "DAVAR_TELEMETRY_PROBE": "debug/tests/telemetry_probe",
    "DAVAR_LAB_LIBRARY": "tools/python/libdavar_lab.so",
}
for variable, program in PROGRAMS.items():
    os.environ.setdefault(variable, str(BUILD / program))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a worker has one core
os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", str(BUILD / "cache/hypothesis"))
os.environ.setdefault("MPLCONFIGDIR", str(BUILD / "cache/matplotlib"))
if (ROOT.parent / "shared/data/real").is_dir():
    os.environ.setdefault("DAVAR_REAL_DATA", str(ROOT.parent / "shared/data/real"))

# A shell starts what it puts into the background without SIGINT, and so would we the programs.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A test imports the packages of the checkout and the helpers of its folder. Names are unique.
sys.dont_write_bytecode = not sys.pycache_prefix
for folder in ["python", "bench", "tools/support", *map(str, sorted(TESTS.glob("*/")))]:
    sys.path.append(str(ROOT / folder))
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(ROOT / "python"), *filter(None, [os.environ.get("PYTHONPATH")])]
)


def pytest_addoption(parser):
    parser.addoption(
        "--gear",
        choices=("quick", "all", "soak"),
        default="all",
        help="quick: without tests marked slow or soak; all: without soak; soak: only these",
    )


def part_of(path):
    """The part of a module: its folder in tests/, or its own name without test_."""
    name = path.relative_to(TESTS).parts[0]
    return name.removeprefix("test_").removesuffix(".py")


@functools.cache
def digest(name):
    """SHA-256 of a file below the root, or of every file of a folder; "" if there is none."""
    path, total = ROOT / name, hashlib.sha256()
    if path.is_dir():
        for child in sorted(path.iterdir()):
            if child.name not in ("__pycache__", "build", ".git"):
                total.update(f"{child.name} {digest(str(child.relative_to(ROOT)))}\n".encode())
        return total.hexdigest()
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else ""


@functools.cache
def machine():
    """What a result depends on outside the tree."""
    compiler = Path(shutil.which("cc") or "cc").resolve()
    variables = {
        name: value
        for name, value in os.environ.items()
        if name.startswith("DAVAR_") and name not in SILENT
    }
    return repr(
        (
            sys.version,
            os.confstr("CS_GNU_LIBC_VERSION"),
            compiler.name,
            compiler.stat().st_size if compiler.exists() else 0,
            sorted(variables.items()),
        )
    )


@functools.cache
def key_of(inputs):
    """The name of the results for the present content of these files."""
    text = "\n".join([machine(), *(f"{name} {digest(name)}" for name in sorted(set(inputs)))])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def inputs_of(item):
    """The files that decide the result of a test: those of its part, or its marker `inputs`."""
    if marker := item.get_closest_marker("inputs"):
        return tuple(marker.args)
    part = part_of(item.path)
    own = str(item.path.relative_to(ROOT)) if item.path.parent == TESTS else f"tests/{part}"
    return (own, *EVERYWHERE, *PARTS[part].get("inputs", ()))


def in_gear(item, gear):
    soak, slow = item.get_closest_marker("soak"), item.get_closest_marker("slow")
    return bool(soak) if gear == "soak" else not soak and not (gear == "quick" and slow)


def seconds_of_cpu():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def known_costs():
    """{group of tests: seconds of processor time}, of the last runs here or of the list."""
    there = [path for path in (COSTS, MEASURED) if path.exists()]
    return {group: cost for path in there for group, cost in json.loads(path.read_text()).items()}


class Run:
    """One run: which tests it leaves out, in which order it takes the others, what they did."""

    def __init__(self, config):
        self.config, self.gear = config, config.getoption("gear")
        self.keys, self.cached, self.cpu = {}, Counter(), {}
        self.outcomes = defaultdict(set)  # of each test, in its phases
        self.costs = known_costs()

    def is_cached(self, item):
        if os.environ.get("DAVAR_AGAIN"):
            return False
        stored = STORE / self.keys[item.nodeid]
        return stored.exists() and item.nodeid in stored.read_text().splitlines()

    def group_of(self, item):
        """Tests of one group run one after the other in one process, which shares fixtures."""
        marker = item.get_closest_marker("xdist_group")
        return marker.args[0] if marker else str(item.path.relative_to(ROOT))

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items):
        wanted = [item for item in items if in_gear(item, self.gear)]
        self.keys = {item.nodeid: key_of(inputs_of(item)) for item in wanted}
        kept = []
        for item in wanted:
            if self.is_cached(item):
                self.cached[part_of(item.path)] += 1
            else:
                kept.append(item)
        for item in kept:
            item.add_marker(pytest.mark.xdist_group(self.group_of(item)))
        left_out = set(items) - set(kept)
        self.config.hook.pytest_deselected(items=[item for item in items if item in left_out])
        # the longest group first; the tests of a group stay together
        place = {item: number for number, item in enumerate(kept)}
        kept.sort(
            key=lambda item: (
                -self.costs.get(self.group_of(item), 1.0),
                self.group_of(item),
                place[item],
            )
        )
        items[:] = kept

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        before = seconds_of_cpu()
        result = yield
        group = self.group_of(item)
        self.cpu[group] = self.cpu.get(group, 0.0) + seconds_of_cpu() - before
        name = self.name_of(item.nodeid)
        if self.outcomes[name] == {"passed"}:  # at once: an interrupted run keeps what it has
            STORE.mkdir(parents=True, exist_ok=True)
            with open(STORE / self.keys[name], "a") as stored:
                stored.write(f"{name}\n")
        return result

    def name_of(self, nodeid):
        """Without the group that xdist appends."""
        controls = self.config.getoption("dist", "no") == "loadgroup"
        grouped = controls or getattr(self.config.option, "loadgroup", False)  # of a worker
        return (nodeid.rpartition("@")[0] or nodeid) if grouped else nodeid

    def pytest_runtest_logreport(self, report):
        outcome = "failed" if hasattr(report, "wasxfail") else report.outcome
        self.outcomes[self.name_of(report.nodeid)].add(outcome)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node, error):
        done = getattr(node, "workeroutput", {})
        self.cached = Counter(done.get("cached", self.cached))
        for group, seconds in done.get("cpu", {}).items():
            self.cpu[group] = self.cpu.get(group, 0.0) + seconds

    def pytest_sessionfinish(self, session, exitstatus):
        if hasattr(self.config, "workeroutput"):
            self.config.workeroutput |= {"cached": dict(self.cached), "cpu": self.cpu}
            return
        MEASURED.parent.mkdir(parents=True, exist_ok=True)
        measured = known_costs() | {group: round(cpu, 1) for group, cpu in self.cpu.items()}
        MEASURED.write_text(json.dumps(measured, indent=0, sort_keys=True) + "\n")
        if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and self.cached:
            session.exitstatus = pytest.ExitCode.OK

    def pytest_terminal_summary(self, terminalreporter):
        done, work = defaultdict(Counter), Counter()
        for name, seen in self.outcomes.items():
            how = next(word for word in ("failed", "skipped", "passed") if word in seen)
            done[part_of(ROOT / name.partition("::")[0])][how] += 1
        for group, seconds in self.cpu.items():
            work[part_of(ROOT / group.partition("::")[0])] += seconds
        terminalreporter.section("parts")
        for part in sorted(done.keys() | self.cached.keys()):
            counts = [f"{count} {how}" for how, count in sorted(done[part].items())]
            counts += [f"{self.cached[part]} unchanged"] if self.cached[part] else []
            line = f"{part:<13} {', '.join(counts):<40} {work[part]:6.0f} s of work"
            terminalreporter.write_line(line)
        longest = sorted(self.cpu.items(), key=lambda one: -one[1])[:25]
        if lines := [f"{cpu:6.0f} s  {group}" for group, cpu in longest if cpu >= 1.0]:
            terminalreporter.section("most work")
            terminalreporter.write_line("\n".join(lines))


def pytest_make_parametrize_id(val, argname):
    """Bytes are not part of a name: gzip's hold the time, and all workers must collect the same."""
    return argname if isinstance(val, bytes) else None


def pytest_configure(config):
    for line in (
        "slow: takes seconds; left out by the quick gear",
        "soak: takes minutes, or can hardly fail; only tools/soak runs it",
        "inputs(*names): the files that decide the result of this test, below the root",
    ):
        config.addinivalue_line("markers", line)
    config.pluginmanager.register(Run(config), "davar-run")
