"""tools/davar-mutants: builds a part of the tree with all its mutants, runs the tests that reach a
sample of them, and reports the survivors.

A mutant is killed if a suite that passes without it fails, crashes, or exceeds its CPU time (ten
times its time without the mutant, plus two seconds). The limit is CPU time, because a busy machine
must not kill mutants.
"""

import argparse
import compileall
import hashlib
import json
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import python_sites
import schemata

ROOT = Path(__file__).resolve().parents[2]
BASE = ROOT / "build/mutants"
HERE = ROOT / "tests/mutation"
SEED = 16
TRIALS = 50  # of tests/property, which are 500 elsewhere
# FOREVER_SAMPLES: of tests/tracking, which are 10^7 elsewhere
FLAGS = "-w -O1 -fwrapv -D_GNU_SOURCE -DFOREVER_SAMPLES=200000U -include {}"
SANITIZERS = " -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer"
PLACES = 131072  # DAVAR_MUTANTS_MAX
Z_95 = 1.959964
KILLED = ("test", "crash", "time")
TIMED_OUT = (-signal.SIGXCPU, -signal.SIGKILL)
PROGRAMS = "davar-sim davar-node davar-plan davar-promise davar_lab wire_probe telemetry_probe"
HEAVY = "numpy scipy.optimize scipy.signal scipy.special scipy.stats starlette.applications uvicorn"


@dataclass(frozen=True)
class Part:
    sources: tuple  # folders of its code
    suites: tuple = ()  # patterns of the C suites, folder/name
    tests: tuple = ()  # patterns of the pytest modules below tests/
    imports: str = ""  # slow ones of the tests


PARTS = {
    "lib": Part(
        ("lib/src", "lib/include", "addons"), ("unit/*", "api/*", "tracking/*", "property/*"), ()
    ),
    "host_sim": Part(("host_sim",), ("unit/text",), ("cli/test_*.py", "wire/test_*.py")),
    "gateway": Part(("gateway",), (), ("wire/test_*.py",)),
    "planner": Part(("python/planner",), (), ("tools/test_*plan*.py",)),
    "davarlab": Part(("python/davarlab",), (), ("lab/test_*.py", "wire/test_*.py"), HEAVY),
}
C_PARTS = {"lib": ("lib",), "rest": ("host_sim", "gateway")}  # of each copy of the tree
POOL = ThreadPoolExecutor(os.cpu_count() or 2)
DRAWN = ("python/davarlab/report/plot.py",)  # only looks


def write(path, text):
    """Writes only if the text differs, because make rebuilds newer files."""
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class Copy:
    """A copy of the tree with the mutants of a part, and its builds."""

    def __init__(self, part):
        self.part = PARTS[part]
        self.name = "lib" if part == "lib" else "rest"
        self.work = BASE / self.name
        self.tree = self.work / "tree"
        self.refused = {}
        self.places = []  # of Python
        of_c = [PARTS[name].sources for name in C_PARTS[self.name]]
        self.folders = [folder for folders in of_c for folder in folders]

    def fill(self):
        """Copies the tree, without the sources that are written with their mutants."""
        wanted, total = set(), hashlib.sha256()
        for folder, folders, names in os.walk(ROOT):
            folders[:] = sorted(set(folders) - {"build", ".git", "__pycache__"})
            for path in (Path(folder, name) for name in sorted(names)):
                name = path.relative_to(ROOT)
                if path.is_symlink():
                    continue
                wanted.add(name)
                total.update(f"{name} {hashlib.sha256(path.read_bytes()).digest()}".encode())
                target = self.tree / name
                if self.is_rendered(name):
                    continue
                if str(name) == "tests/CMakeLists.txt":
                    trials = f"set(property_trials {TRIALS})"
                    text = re.sub(r"set\(property_trials \d+\)", trials, path.read_text())
                    write(target, text)
                elif not target.exists() or target.read_bytes() != path.read_bytes():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy2(path, target)
        for folder, folders, names in os.walk(self.tree):
            folders[:] = [name for name in folders if Path(folder, name) != self.tree / "build"]
            for path in (Path(folder, name) for name in names):
                if path.relative_to(self.tree) not in wanted:
                    path.unlink()
        self.digest = total.hexdigest()[:32]

    def is_rendered(self, name):
        return name.suffix in schemata.SUFFIXES and any(
            name.is_relative_to(folder) for folder in self.folders
        )

    def build(self):
        """Every mutant of the part that compiles."""
        self.fill()
        files = schemata.find(ROOT, self.folders, schemata.compiler_flags(ROOT))
        for _ in range(8):
            mutants = schemata.numbered(files, self.refused)
            for name, file in files.items():
                write(self.tree / name, schemata.render(file, self.refused))
            status, output = self.compile("plain")
            if status == 0:
                break
            more = refused_sites(files, self.refused, output)
            if not more:
                sys.exit(f"davar-mutants: the build fails:\n{output[-6000:]}")
            self.refused.update(more)
        else:
            sys.exit("davar-mutants: the build keeps failing")
        if self.name == "rest":
            mutants += self.build_python(1 + len(mutants))
        if len(mutants) >= PLACES:
            sys.exit(f"davar-mutants: more than {PLACES} mutants")
        mine = [f"{folder}/" for folder in self.part.sources]
        return [one for one in mutants if one.file.startswith(tuple(mine))]

    def build_python(self, number):
        """The mutants of the packages, which load python_hook, and the folders of a build that
        their tests expect.
        """
        mutants, first = [], {}
        for part in ("planner", "davarlab"):
            (folder,) = PARTS[part].sources
            for path in sorted((self.tree / folder).rglob("*.py")):
                name = str(path.relative_to(self.tree))
                if name not in DRAWN:
                    file = python_sites.File(name, path.read_text(), number + len(mutants))
                    first[name] = number + len(mutants)
                    mutants += file.mutants
                    self.places += file.places
            start = self.tree / folder / "__init__.py"
            hook = f"import sys; sys.path.append({str(self.tree / 'tests/mutation')!r})"
            end = re.match(r'""".*?"""\n', start.read_text(), re.DOTALL).end()
            text = (ROOT / folder / "__init__.py").read_text()
            write(start, f"{text[:end]}{hook}; import python_hook\n{text[end:]}")
            del first[str(start.relative_to(self.tree))]
            compileall.compile_dir(self.tree / folder, quiet=1)  # the workers only read
        shutil.rmtree(self.work / "recording", ignore_errors=True)
        write(self.work / "index.json", json.dumps(first))
        built = self.tree / "build"
        (built / "log").mkdir(parents=True, exist_ok=True)
        for name in ("tools", "release", "debug"):
            link(built / name, self.work / "plain")
        for path in (ROOT / "build").glob("venv-*"):
            link(built / path.name, path)
        for name in PROGRAMS.split():
            (self.work / f"plain/built-{name}").touch()
        return mutants

    def compile(self, kind):
        """(status, output) of the build `kind`: plain or sanitize."""
        folder = self.work / kind
        flags = FLAGS.format(self.tree / "tests/mutation/mutant.h")
        flags += SANITIZERS if kind == "sanitize" else ""
        targets = [path.stem for path in self.suite_sources()]
        targets += PROGRAMS.split() if self.name == "rest" else []
        ninja = shutil.which("ninja")
        is_rest = "ON" if self.name == "rest" else "OFF"
        for step in (
            [
                *("cmake", "-S", self.tree, "-B", folder, "-DCMAKE_BUILD_TYPE=Mutants"),
                *("-G", "Ninja" if ninja else "Unix Makefiles"),
                *(f"-DDAVAR_BUILD_SIM={is_rest}", f"-DDAVAR_BUILD_PYTHON={is_rest}"),
                "-DDAVAR_BUILD_BENCH=OFF",
                f"-DCMAKE_C_FLAGS_MUTANTS={flags}",
                f"-DDAVAR_UNITY_DIR={os.environ.get('DAVAR_UNITY_DIR', '')}",
            ],
            [
                *("cmake", "--build", folder, "--parallel", str(os.cpu_count() or 2)),
                *("--target", *targets, "--", "-k", *(["0"] if ninja else [])),
            ],
        ):
            done = subprocess.run(
                step,
                text=True,
                errors="replace",
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                check=False,
            )
            if done.returncode:
                break
        return done.returncode, done.stdout

    def suite_sources(self):
        """The sources of the C suites of every part in this copy."""
        parts = [part for name, part in PARTS.items() if (name == "lib") == (self.name == "lib")]
        patterns = sorted({pattern for part in parts for pattern in part.suites})
        return [
            path
            for pattern in patterns
            for path in sorted(self.tree.glob(f"tests/{pattern.replace('/', '/test_')}.c"))
        ]

    def suites(self, options, kind="plain"):
        """The suites of the part that pass without a mutant."""
        found = [
            Program(f"{path.parent.name}/{path.stem.removeprefix('test_')}", program, self.work)
            for path in self.suite_sources()
            if (program := self.work / kind / "tests" / path.stem).exists()
            and any(path.match(f"{one.replace('/', '/test_')}.c") for one in self.part.suites)
        ]
        modules = [path for one in self.part.tests for path in (self.tree / "tests").glob(one)]
        found += [Module(path, self, options.longest, options.measure) for path in sorted(modules)]
        measured = POOL.map(lambda suite: suite.measure(), found)
        return [suite for suite, passes in zip(found, measured) if passes]

    def reach(self, mutants):
        """The places whose tests are those of a mutant: its own; for code that runs at import, the
        statements that mention what it defines.
        """
        reach = {mutant.id: {mutant.first_id} for mutant in mutants}
        at_import = [place for place in self.places if place.body is None]
        wanted = [place for place in at_import if any(one.id in reach for one in place.mutants)]
        if not wanted:
            return reach
        mentions = defaultdict(set)
        for place in self.places:
            if place.body is not None:
                statement = place.body[place.index]
                for name in set(python_sites.mentioned(statement)):
                    mentions[name].add(place.mutants[0].id)
        for place in wanted:
            ids = set().union(*(mentions[name] for name in place.names))
            if not ids:  # any of the same file
                ids = {one.mutants[0].id for one in self.places if one.body and same(one, place)}
            for mutant in place.mutants:
                if mutant.id in reach:
                    reach[mutant.id] = ids
        return reach


def same(place, other):
    return place.mutants[0].file == other.mutants[0].file


def link(path, target):
    if path.is_symlink() and path.readlink() != target:
        path.unlink()
    if not path.exists():
        path.symlink_to(target)


def refused_sites(files, refused, output):
    """The sites on the lines that the compiler complains of."""
    more = {}
    for name, line, reason in re.findall(r"tree/([\w./]+):(\d+):\d+: error: (.*)", output):
        file = files.get(name)
        for span, site in file.sites.items() if file else ():
            is_there = site.mutants and site.mutants[0][0].line == int(line)
            if is_there and (name, *span) not in refused:
                more[(name, *span)] = reason
    return more


class Suite:
    """seconds: its CPU time without a mutant. reached: the places that it runs."""

    def kills(self, mutant, ids):
        """The cause of death and the test, or None."""
        status, name = self.run(mutant, ids)
        how = "time" if status in TIMED_OUT else "crash" if status < 0 else "test"
        return (how, name) if status else None


class Program(Suite):
    """A C suite."""

    def __init__(self, name, program, work):
        self.name, self.program, self.work = name, program, work

    def measure(self):
        file = self.work / f"reached-{self.program.name}"
        file.write_bytes(bytes(PLACES))
        status, self.seconds = self.execute("0", {"DAVAR_MUTANTS_REACHED": str(file)})
        self.reached = {match.start() for match in re.finditer(b"\1", file.read_bytes())}
        if status:
            print(f"not used, fails without a mutant: {self.name} (status {status})")
        return not status

    def execute(self, number, variables=None, limit_s=None):
        """(status, CPU seconds)."""

        def limit():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if limit_s:
                resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s + 1))

        process = subprocess.Popen(
            [self.program],
            env={**os.environ, **(variables or {}), "DAVAR_MUTANT": number},
            preexec_fn=limit,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self.work,
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, used.ru_utime + used.ru_stime

    def run(self, mutant, ids):
        return self.execute(str(mutant.id), None, math.ceil(10 * self.seconds) + 2)[0], self.name

    def cost(self, ids):
        return self.seconds


@dataclass
class Module(Suite):
    """A module of pytest in the copy of the tree."""

    path: Path
    copy: Copy
    longest: float  # CPU seconds for one mutant
    most_s: float  # and for the recording
    tests: dict = field(default_factory=dict)  # {name: [CPU seconds, places]}
    seconds: float = 0.0  # of the process

    @property
    def name(self):
        return f"{self.path.parent.name}/{self.path.stem.removeprefix('test_')}"

    def measure(self):
        stored = self.copy.work / f"measured/{self.copy.digest}/{self.most_s:g}/{self.name}.json"
        if stored.exists():
            done = json.loads(stored.read_text())
        else:
            reached = self.copy.work / f"reached-{self.path.stem}"
            reached.write_bytes(bytes(PLACES))
            done = self.ask("0", {"DAVAR_MUTANTS_REACHED": str(reached)}, None, 1800, None)
            stored.parent.mkdir(parents=True, exist_ok=True)
            stored.write_text(json.dumps(done))
        failed = set(done["failed"])
        self.tests = {name: one for name, one in done["tests"].items() if name not in failed}
        self.seconds = done["seconds"]
        self.reached = {at for _, places in self.tests.values() for at in places}
        if done["status"] not in (0, 1, 2, 5):
            failed = {f"all of {self.name} (status {done['status']})"}
        for name in sorted(failed):
            print(f"not used, fails without a mutant: {name}", flush=True)
        return done["status"] in (0, 1, 2) and bool(self.tests)

    def ask(self, number, variables, tests, hang_s, limit_s):
        plain = self.copy.work / "plain"
        named = {
            "DAVAR_SIM": "host_sim/davar-sim",
            "DAVAR_NODE": "gateway/davar-node",
            "DAVAR_WIRE_PROBE": "tests/wire_probe",
            "DAVAR_TELEMETRY_PROBE": "tests/telemetry_probe",
            "DAVAR_PLAN": "tools/plan/davar-plan",
            "DAVAR_LAB_LIBRARY": "python/libdavar_lab.so",
        }
        programs = {name: str(plain / program) for name, program in named.items()}
        return worker(self.copy).ask(
            {
                "module": str(self.path.relative_to(self.copy.tree)),
                "variables": {**programs, **variables, "DAVAR_MUTANT": number, "DAVAR_BUILT": "1"},
                "tests": tests,
                "hang_s": math.ceil(hang_s),
                "most_s": 0 if tests else self.most_s,
                "limit_s": limit_s and math.ceil(limit_s),
                "log": str(self.copy.work / f"tests-{self.path.stem}.log"),
            }
        )

    def run(self, mutant, ids):
        """Tests that reach the place come first, the quickest ahead. The others follow, because
        they may use what an earlier test has stored; but only to a limit of time.
        """

        def order(name):
            seconds, places = self.tests[name]
            return ids.isdisjoint(places), seconds

        chosen, total = [], 0.0
        for name in sorted(self.tests, key=order):
            total += self.tests[name][0]
            if chosen and total > self.longest:
                break
            chosen.append(name)
        limit_s = 10 * (total + 2) + 2
        done = self.ask(str(mutant.id), {}, chosen, 60 + 3 * limit_s, limit_s)
        return done["status"], (*done["failed"], self.name)[0]

    def cost(self, ids):
        """Of the tests that reach one of these places."""
        return sum(seconds for seconds, places in self.tests.values() if not ids.isdisjoint(places))


class Worker:
    """A process of pytest_worker.py; one for each thread."""

    of_thread = threading.local()

    def __init__(self, copy):
        folders = os.pathsep.join(map(str, (copy.tree / "python",)))
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-B", copy.tree / "tests/mutation/pytest_worker.py"),
                *copy.part.imports.split(),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=copy.tree,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": folders},
        )

    def ask(self, job):
        self.process.stdin.write(json.dumps(job) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


def worker(copy):
    if not hasattr(Worker.of_thread, "one"):
        Worker.of_thread.one = Worker(copy)
    return Worker.of_thread.one


def fate(mutant, ids, suites, longest_s):
    """The outcome of a mutant: (fate, test)."""
    reaching = [(one.cost(ids), one) for one in suites if not one.reached.isdisjoint(ids)]
    used = 0.0
    for cost, suite in sorted(reaching, key=lambda pair: pair[0]):
        used += cost
        if longest_s < used and cost < used:
            return "survived", ""
        if how := suite.kills(mutant, ids):
            return how
    return ("survived" if reaching else "not reached"), ""


def outcomes(copy, name, mutants, suites, longest_s):
    """[(mutant, fate, test)], one process per core; a line for each in the log."""
    results, reach = [], copy.reach(mutants)

    def one(mutant):
        return fate(mutant, reach[mutant.id], suites, longest_s)

    with (BASE / f"{name}.tsv").open("a") as log:
        for mutant, (how, test) in zip(mutants, POOL.map(one, mutants)):
            results.append((mutant, how, test))
            log.write(f"{how}\t{test}\t{mutant.kind}\t{mutant.line}\t{mutant.key}\n")
            log.flush()
            if len(results) % 200 == 0:
                print(f"  {len(results)} of {len(mutants)}", file=sys.stderr, flush=True)
    return results


def wilson(killed, of):
    """The 95 % interval of a share (Wilson)."""
    if not of:
        return 0.0, 1.0
    share, z2 = killed / of, Z_95**2 / of
    middle = (share + z2 / 2) / (1 + z2)
    half = Z_95 * math.sqrt(share * (1 - share) / of + z2 / of / 4) / (1 + z2)
    return middle - half, middle + half


def report(results, listed, everything):
    """Prints the outcome; returns the number of survivors that are not listed."""
    groups = defaultdict(Counter)
    for mutant, how, _ in results:
        alive = "equivalent" if mutant.key in listed else how
        for name in (str(Path(mutant.file).parent), mutant.kind, "all"):
            groups[name]["killed" if how in KILLED else alive] += 1
    columns = ("killed", "survived", "not reached", "equivalent")
    print(f"{'':<36}" + "".join(f"{name:>12}" for name in columns))
    for name, counts in sorted(groups.items(), key=lambda one: one[0] == "all"):
        print(f"{name:<36}" + "".join(f"{counts[column]:>12}" for column in columns))
    by = Counter(how for _, how, _ in results)
    killed, same = groups["all"]["killed"], groups["all"]["equivalent"]
    low, high = wilson(killed, len(results) - same)
    print(
        f"killed by a failing test {by['test']}, a crash {by['crash']}, CPU time {by['time']}; "
        f"{len(results)} of {everything} mutants; {100 * killed / max(len(results) - same, 1):.1f} "
        f"% without equivalents, 95 % interval {100 * low:.1f} to {100 * high:.1f} %"
    )
    unlisted = 0
    for mutant, how, test in results:
        if how in KILLED and mutant.key in listed:
            print(f"listed, but killed by {test}: {mutant.key}")
        elif how not in KILLED and mutant.key not in listed:
            unlisted += 1
            print(f"{how}: {mutant.file}:{mutant.line}\n  {mutant.key}")
    return unlisted


def main():
    parser = argparse.ArgumentParser(prog="davar-mutants", add_help=False)
    parser.add_argument("--of", choices=PARTS, default="lib")
    parser.add_argument("--sample", type=int, default=2000)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--longest", type=float, default=60)
    parser.add_argument("--measure", type=float, default=600)
    parser.add_argument("--sanitize", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--unlisted", action="store_true")
    parser.add_argument("--seed", type=int, default=SEED)
    options = parser.parse_args()
    copy = Copy(options.of)
    copy.work.mkdir(parents=True, exist_ok=True)
    lines = map(str.strip, (HERE / "survivors.txt").read_text().splitlines())
    listed = {line for line in lines if line and not line.startswith("#")}
    mutants = copy.build()
    for (name, start, _), reason in copy.refused.items():
        print(f"not compiled: {name}, byte {start}: {reason}")
    folders = tuple(f"{folder}/" for folder in copy.part.sources)
    mine = {key for key in listed if key.startswith(folders)}
    stale = sorted(mine - {mutant.key for mutant in mutants})
    for key in stale:
        print(f"listed, but no mutant any more: {key}")
    # A larger sample contains the smaller one.
    chosen = sorted(
        (mutant for mutant in mutants if options.only in mutant.key),
        key=lambda mutant: mutant.draw(options.seed),
    )
    chosen = chosen if options.all else chosen[: options.sample]
    if options.unlisted:
        chosen = [mutant for mutant in chosen if mutant.key not in listed]
    (BASE / f"{options.of}.tsv").unlink(missing_ok=True)
    results = outcomes(copy, options.of, chosen, copy.suites(options), options.longest)
    if options.sanitize:
        status, output = copy.compile("sanitize")
        if status:
            sys.exit(f"davar-mutants: the build fails:\n{output[-6000:]}")
        left = [one for one, how, _ in results if how == "survived" and one.key not in listed]
        again = outcomes(copy, options.of, left, copy.suites(options, "sanitize"), options.longest)
        found = {mutant.key: (mutant, how, test) for mutant, how, test in again}
        results = [found.get(result[0].key, result) for result in results]
    unlisted = report(results, listed, len(mutants))
    print(
        f"{len(chosen)} mutants tested, {unlisted} neither killed nor listed, {len(stale)} listed "
        "that no longer exist"
    )
    return 1 if unlisted or stale else 0


if __name__ == "__main__":
    sys.exit(main())
