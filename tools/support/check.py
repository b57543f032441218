"""Runs the tests of one gear: makes what they need, in parallel, then starts pytest. Called by
tools/test. Standard library only.
"""

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BUILD, TESTS = ROOT / "build", ROOT / "tests"
PARTS: dict[str, dict[str, Any]] = tomllib.loads((TESTS / "parts.toml").read_text("utf-8"))
BASE = ["gcc", "libc6-dev", "make", "cmake", "zlib1g-dev", "python3", "python3-venv", "ccache"]
BASE += ["pkg-config", "libgpiod-dev"]
# The programs behind the commands in tools/; "all" also builds the benchmark.
QUICK_TOOLS = ("davar-sim", "davar-plan", "davar-promise", "davar_lab", "davar_python")
ALL_TOOLS = (*QUICK_TOOLS, "davar-node", "all")
WORKERS = (os.cpu_count() or 2) + 1  # one more than cores: some tests wait for a clock or a page


class Broken(Exception):
    """What a run needs cannot be made. The text is the output of what failed."""


def where(part: str) -> Path:
    """The folder of a part, or its module."""
    module = TESTS / f"test_{part}.py"
    return module if module.exists() else TESTS / part


def setup_functions(words: str, log: str) -> str:
    """Runs functions of tools/support/setup.sh. Returns their last line."""
    done = subprocess.run(
        ["bash", "-c", f". tools/support/setup.sh && {words}"],
        cwd=ROOT,
        text=True,
        errors="replace",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    (BUILD / "log" / log).write_text(done.stdout)
    if done.returncode:
        raise Broken(f"{done.stdout}\nfailed: {words}")
    return (done.stdout.splitlines() or [""])[-1]


def packages(names: Sequence[str], beside: Sequence[str] = ()) -> list[str]:
    """The Debian packages of these parts, and those beside. BOARDS: of the emulated boards."""
    needed = [*BASE, *(one for name in names for one in PARTS[name].get("packages", ())), *beside]
    boards = setup_functions('echo "${target_packages[@]}"', "packages.log").split()
    named = (one for name in needed for one in (boards if name == "BOARDS" else [name]))
    return list(dict.fromkeys(named))


def test_python() -> str:
    """The Python of the tests: the lab's packages, and those of requirements-test.txt."""
    lab, python = (
        setup_functions(
            f"python_environment venv-{name} tools/requirements-{name}.txt", f"{name}-python.log"
        )
        for name in ("lab", "test")
    )
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    paths = [Path(one).parents[1] / "lib" / version / "site-packages" for one in (lab, python)]
    (paths[1] / "lab.pth").write_text(f"{paths[0]}\n")
    return python


def compiled_python(names: list[str]) -> str:
    """test_python(), with every module of the tests in the cache of compiled ones: otherwise each
    worker would compile them all, at the same time."""
    python = test_python()
    words = [python, "-m", "pytest", "--collect-only", "-qq", *(str(where(name)) for name in names)]
    # Without the builds, a module may refuse to be collected. It is compiled before.
    subprocess.run(words, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return python


def prepare(names: list[str], quick: bool) -> str:
    """Builds everything that these parts need. Returns the Python of the tests."""
    presets = dict.fromkeys(preset for name in names for preset in PARTS[name].get("builds", ()))
    wanted = [f"build {one}" for one in presets if not quick or one == "debug"]
    wanted += [f"build tools {target}" for target in (QUICK_TOOLS if quick else ALL_TOOLS)]
    with ThreadPoolExecutor() as pool:
        python = pool.submit(compiled_python, names)
        for words in wanted:  # one after the other: each uses every core
            setup_functions(words, "build.log")
        return python.result()


def use_ccache() -> None:
    """Lets every build by CMake share its objects through ccache, also with other clones."""
    if shutil.which("ccache"):
        os.environ.setdefault("CMAKE_C_COMPILER_LAUNCHER", "ccache")
        os.environ.setdefault("CCACHE_BASEDIR", str(ROOT))  # paths below it do not count
        os.environ.setdefault("CCACHE_NOHASHDIR", "1")  # nor does the folder of the build


def listing() -> str:
    """The table of --list."""
    costs: dict[str, float] = json.loads((TESTS / "costs.json").read_text())
    lines = []
    for name, part in PARTS.items():
        prefix = str(where(name).relative_to(ROOT))
        seconds = sum(cost for group, cost in costs.items() if group.startswith(prefix))
        gear = "soak" if part.get("soak") else "quick" if part.get("quick") else "all"
        lines.append(f"{name:<13} {gear:<6} {seconds:5.0f} s  {part['finds']}")
    return "\n".join(["part          gear    work   what only this part finds", *lines])


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools/test", add_help=False)
    parser.add_argument("--only", default="")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--packages", action="store_true")
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    if options.list:
        with contextlib.suppress(BrokenPipeError):  # of head
            print(listing(), flush=True)
        return 0
    quick = not options.all and not options.only
    names = [name for name in options.only.split(",") if name] or [
        name
        for name, part in PARTS.items()
        if not part.get("soak") and (part.get("quick") or not quick)
    ]
    if unknown := [name for name in names if name not in PARTS]:
        raise SystemExit(f"tools/test: --only {unknown[0]}: no such part (see --list)")
    if options.packages:
        print("\n".join(packages(names)))
        return 0
    use_ccache()
    os.environ["PYTHONPYCACHEPREFIX"] = str(BUILD / "cache/pyc")  # compiled once, not in the tree
    (BUILD / "log").mkdir(parents=True, exist_ok=True)
    try:
        python = prepare(names, quick)
    except Broken as why:
        print(why)
        return 1
    os.environ["DAVAR_BUILT"] = "1"
    command = [python, "-m", "pytest", f"--gear={'quick' if quick else 'all'}", "-q", "-rsfE"]
    command += [f"--numprocesses={WORKERS}", "--dist=loadgroup", "--no-loadscope-reorder"]
    return subprocess.run(
        [*command, *options.words, *(str(where(name)) for name in names)], cwd=ROOT
    ).returncode


if __name__ == "__main__":
    sys.exit(main())
