"""tools/davar-mutants: builds lib/ with all its mutants, runs the fast suites on a sample of them,
and reports the survivors.

A mutant is killed if a suite that passes without it fails, crashes, or exceeds its CPU time (ten
times its time without the mutant, plus two seconds). The limit is CPU time, because a busy machine
must not kill mutants.
"""

import argparse
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import schemata

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build/mutants"
TREE, LISTED = WORK / "tree", ROOT / "tests/mutation/survivors.txt"
NOT_COPIED = {"build", ".git", "data", "docs"}
SEED = 16
# The suites in this order: from outside and inside; then the slower ones, for the remaining
# mutants.
TRIALS = 50  # of tests/property, which are 1500 elsewhere
FAST, SLOWER = ("unit", "api"), ("tracking", "property")
# of tests/tracking, which are 10^7 elsewhere
FLAGS = "-w -O1 -fwrapv -D_GNU_SOURCE -DFOREVER_SAMPLES=200000U -include {}"
SANITIZERS = " -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer"
Z_95 = 1.959964


def write(path, text):
    """Writes only if the text differs, because make rebuilds newer files."""
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def copy_tree():
    """The tree without lib's sources, which are written with their mutants."""
    wanted = set()
    for path in ROOT.rglob("*"):
        name = path.relative_to(ROOT)
        if (
            name.parts[0] in NOT_COPIED
            or "__pycache__" in name.parts
            or not path.is_file()
            or path.is_symlink()
        ):
            continue
        wanted.add(name)
        target = TREE / name
        if name.parts[0] == "lib" and name.suffix in schemata.SUFFIXES:
            continue
        if str(name) == "tests/CMakeLists.txt":
            write(
                target,
                re.sub(
                    r"set\(property_trials \d+\)",
                    f"set(property_trials {TRIALS})",
                    path.read_text(),
                ),
            )
        elif not target.exists() or target.read_bytes() != path.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, target)
    for path in [path for path in TREE.rglob("*") if path.is_file()]:
        if path.relative_to(TREE) not in wanted:
            path.unlink()


def compile_tree(kind):
    """(status, output) of the build `kind`: plain or sanitize."""
    folder = WORK / kind
    flags = FLAGS.format(TREE / "tests/mutation/mutant.h") + (
        SANITIZERS if kind == "sanitize" else ""
    )
    names = [
        path.stem
        for folder in FAST + SLOWER
        for path in sorted(TREE.glob(f"tests/{folder}/test_*.c"))
    ]
    steps = [
        [
            "cmake",
            "-S",
            str(TREE),
            "-B",
            str(folder),
            "-DCMAKE_BUILD_TYPE=Mutants",
            "-DDAVAR_BUILD_SIM=OFF",
            "-DDAVAR_BUILD_BENCH=OFF",
            f"-DCMAKE_C_FLAGS_MUTANTS={flags}",
            f"-DDAVAR_UNITY_DIR={os.environ.get('DAVAR_UNITY_DIR', '')}",
        ],
        [
            "cmake",
            "--build",
            str(folder),
            "--parallel",
            str(os.cpu_count() or 2),
            "--target",
            *names,
            "--",
            "-k",
        ],
    ]
    for step in steps:
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


def build():
    """Every mutant that compiles, and the sites that no compiler accepts, with the compiler's
    reason.
    """
    copy_tree()
    files = schemata.find(ROOT, schemata.compiler_flags(ROOT))
    refused = {}
    for _ in range(8):
        mutants = schemata.number(files, refused)
        for name, file in files.items():
            write(TREE / name, schemata.render(file, refused))
        status, output = compile_tree("plain")
        if status == 0:
            return mutants, refused
        more = refused_sites(files, refused, output)
        if not more:
            sys.exit(f"davar-mutants: the build fails:\n{output[-6000:]}")
        refused.update(more)
    sys.exit("davar-mutants: the build keeps failing")


def refused_sites(files, refused, output):
    """The sites on the lines that the compiler complains of."""
    more = {}
    for name, line, reason in re.findall(r"tree/(lib/[\w./]+):(\d+):\d+: error: (.*)", output):
        file = files[name]
        for span, site in file.sites.items():
            if (
                site.mutants
                and site.mutants[0][0].line == int(line)
                and (name, *span) not in refused
            ):
                more[(name, *span)] = reason
    return more


def suites(kind):
    """{name: program} of the selected suites, by folder."""
    found = {}
    for path in sorted(TREE.glob("tests/*/test_*.c")):
        folder, name = path.parent.name, path.stem
        if folder in FAST + SLOWER and (WORK / kind / "tests" / name).exists():
            found[f"{folder}/{name.removeprefix('test_')}"] = WORK / kind / "tests" / name
    return found


TIMED_OUT = (-signal.SIGXCPU, -signal.SIGKILL)


def execute(program, variables, limit_s=None):
    """(status, CPU seconds) of one suite."""

    def limit():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if limit_s:
            resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s + 1))

    process = subprocess.Popen(
        [program],
        env={**os.environ, **variables},
        preexec_fn=limit,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=WORK,
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, used.ru_utime + used.ru_stime


class Suite:
    """A suite, its time without a mutant, and the sites that it reaches."""

    def __init__(self, name, program):
        self.name, self.program = name, program
        reached = WORK / f"reached-{program.parents[1].name}-{program.name}"
        reached.unlink(missing_ok=True)
        status, self.seconds = execute(
            program, {"DAVAR_MUTANTS_REACHED": str(reached), "DAVAR_MUTANT": "0"}
        )
        if status:
            sys.exit(f"davar-mutants: {name} fails without a mutant (status {status})")
        self.reached = reached.read_bytes() if reached.exists() else b""
        self.limit_s = math.ceil(10 * self.seconds) + 2

    def kills(self, mutant):
        """The cause of death, or an empty text."""
        status, _ = execute(self.program, {"DAVAR_MUTANT": str(mutant.id)}, self.limit_s)
        return (
            ("time" if status in TIMED_OUT else "crash" if status < 0 else "test")
            if status
            else None
        )


class Listed:
    """Reads tests/mutation/survivors.txt: `## equivalent: reason` or `## gap: reason`, followed by
    the mutants.
    """

    def __init__(self, path):
        self.reason = {}
        heading = None
        for line in path.read_text().splitlines() if path.exists() else ():
            if line.startswith("## "):
                heading = tuple(line[3:].split(": ", 1))
            elif line.strip() and not line.startswith("#"):
                self.reason[line.strip()] = heading

    def is_equivalent(self, mutant):
        return self.reason.get(mutant.key, ("",))[0] == "equivalent"


def sample(mutants, count, seed):
    """`count` mutants at random, all equally likely. A larger sample contains the smaller one, and
    a mutant keeps its place while the text of its function is unchanged.
    """
    return sorted(mutants, key=lambda mutant: mutant.draw(seed))[:count]


def fate(mutant, asked):
    """The outcome of a mutant: (fate, suite)."""
    reaching = [suite for suite in asked if suite.reached[mutant.first_id]]
    for suite in reaching:
        how = suite.kills(mutant)
        if how:
            return how, suite.name
    return ("survived" if reaching else "not reached"), ""


def ask(mutants, asked):
    """[(mutant, fate, suite)], one process per core; a line for each in build/mutants/log.tsv."""
    results = []
    with (WORK / "log.tsv").open("a") as log, ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        for mutant, (how, suite) in zip(
            mutants, pool.map(lambda mutant: fate(mutant, asked), mutants)
        ):
            results.append((mutant, how, suite))
            log.write(f"{how}\t{suite}\t{mutant.kind}\t{mutant.line}\t{mutant.key}\n")
            log.flush()
            if len(results) % 200 == 0:
                print(f"  {len(results)} of {len(mutants)}", file=sys.stderr, flush=True)
    return results


def prepared(kind, longest_s, names):
    """The suites of a build within the time limit (and in the selection, if there is one), the
    fastest first.
    """
    found = [
        Suite(name, program) for name, program in suites(kind).items() if not names or name in names
    ]
    return sorted(
        (suite for suite in found if suite.seconds <= longest_s), key=lambda suite: suite.seconds
    )


def wilson(killed, of):
    """The 95 % interval of a share (Wilson)."""
    if not of:
        return 0.0, 1.0
    share, z2 = killed / of, Z_95**2 / of
    middle, half = (
        (share + z2 / 2) / (1 + z2),
        Z_95 * math.sqrt(share * (1 - share) / of + z2 / of / 4) / (1 + z2),
    )
    return middle - half, middle + half


def table(results, listed, key):
    """A line for each directory or kind: mutants, killed, survived, not reached, equivalent, share
    killed of those that are not.
    """
    lines = [
        f"{'':<22}{'mutants':>8}{'killed':>8}{'survived':>9}{'unreached':>10}{'equivalent':>11}{'score':>8}"
    ]
    groups = defaultdict(list)
    for result in results:
        groups[key(result[0])].append(result)
    for name, those in [*sorted(groups.items()), ("all", results)]:
        killed = sum(how in KILLED for _, how, _ in those)
        same = sum(how not in KILLED and listed.is_equivalent(mutant) for mutant, how, _ in those)
        unreached = sum(
            how == "not reached" and not listed.is_equivalent(mutant) for mutant, how, _ in those
        )
        alive = len(those) - killed - same - unreached
        score = killed / max(len(those) - same, 1)
        lines.append(
            f"{name:<22}{len(those):>8}{killed:>8}{alive:>9}{unreached:>10}{same:>11}"
            f"{100 * score:>7.1f}%"
        )
    return lines


def report(results, listed, everything):
    """Prints the outcome; returns the number of survivors that are not listed."""
    print("\n".join(table(results, listed, lambda mutant: room(mutant.file))), end="\n\n")
    print("\n".join(table(results, listed, lambda mutant: mutant.kind)), end="\n\n")
    by = Counter(how for _, how, _ in results)
    killed, same = (
        sum(by[how] for how in KILLED),
        sum(how not in KILLED and listed.is_equivalent(mutant) for mutant, how, _ in results),
    )
    low, high = wilson(killed, len(results) - same)
    print(
        f"killed by a failing test {by['test']}, a crash {by['crash']}, CPU time {by['time']}; "
        f"{len(results)} of {everything} mutants; "
        f"score 95 % interval {100 * low:.1f} to {100 * high:.1f} %"
    )
    unlisted = [
        (mutant, how)
        for mutant, how, _ in results
        if how not in KILLED and mutant.key not in listed.reason
    ]
    for mutant, how in unlisted:
        print(f"{how}: {mutant.file}:{mutant.line}\n  {mutant.key}")
    for mutant, how, suite in results:
        if how in KILLED and mutant.key in listed.reason:
            print(f"listed, but killed by {suite}: {mutant.key}")
    return len(unlisted)


def room(name):
    parts = Path(name).parts
    return parts[2] if len(parts) > 3 else Path(name).name


KILLED = ("test", "crash", "time")


def main():
    parser = argparse.ArgumentParser(prog="davar-mutants", add_help=False)
    parser.add_argument("--sample", type=int, default=2000)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--longest", type=float, default=30)
    parser.add_argument("--sanitize", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--again", metavar="LOG")
    parser.add_argument("--unlisted", action="store_true")
    parser.add_argument("--suites", type=lambda text: text.split(","), default=[])
    parser.add_argument("--seed", type=int, default=SEED)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    listed = Listed(LISTED)
    mutants, refused = build()
    for (name, start, _), reason in refused.items():
        print(f"not compiled: {name}, byte {start}: {reason}")
    stale = sorted(set(listed.reason) - {mutant.key for mutant in mutants})
    for key in stale:
        print(f"listed, but no mutant any more: {key}")
    chosen = [mutant for mutant in mutants if options.only in mutant.key]
    if options.again:  # the survivors of an earlier log
        earlier = dict(
            reversed(line.split("\t", 4)[::4])
            for line in Path(options.again).read_text().splitlines()
        )
        chosen = [
            mutant for mutant in chosen if earlier.get(mutant.key) in ("survived", "not reached")
        ]
    elif not options.all:
        chosen = sample(chosen, options.sample, options.seed)
    if options.unlisted:
        chosen = [mutant for mutant in chosen if mutant.key not in listed.reason]
    (WORK / "log.tsv").unlink(missing_ok=True)
    results = ask(chosen, prepared("plain", options.longest, options.suites))
    if options.sanitize:
        status, output = compile_tree("sanitize")
        if status:
            sys.exit(f"davar-mutants: the build fails:\n{output[-6000:]}")
        left = [
            mutant
            for mutant, how, _ in results
            if how == "survived" and mutant.key not in listed.reason
        ]
        again = {
            mutant.key: (mutant, how, suite)
            for mutant, how, suite in ask(
                left, prepared("sanitize", options.longest, options.suites)
            )
        }
        results = [again.get(result[0].key, result) for result in results]
    unlisted = report(results, listed, len(mutants))
    print(
        f"{len(chosen)} mutants tested, {unlisted} neither killed nor listed, {len(stale)} listed "
        "that no longer exist"
    )
    return 1 if unlisted or stale else 0


if __name__ == "__main__":
    sys.exit(main())
