"""The command line of tools/davar-plan."""

import json
import os
import shlex
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from . import choice, costs, design, programs, report, sensors, simulate, text, wishes
from .choice import Impossible, Plan
from .wishes import BadOption

USAGE = """\
usage: tools/davar-plan --rate HZ --lsb X --core CORE [options]
       tools/davar-plan --sensor NAME@RATE --core CORE [options]
       tools/davar-plan --taus M,M,... [--long M,M,...] [--bandwidth FILTER --rate HZ]
                        [--name NAME] > plan.c
       tools/davar-plan --floor --rate HZ --lsb X --bandwidth FILTER [--rail N]
                        [--name NAME] > floor_plan.c

The first two forms plan a setup of davar for your gyro, your chip and your wishes. They print its
promises and its costs. With -o FOLDER they write it as C: davar_setup.h and davar_setup.c with the
functions start, push and take, and the options of the build. The third form writes the plan of a
fit alone, and the fourth that of a floor: see --taus --help.

What you have
  --sensor NAME@RATE   a gyro of docs/FIRMWARE.md: its counts, low-pass and typical noise at that
                       sample rate in Hz; other options override these. {sensors}
  --rate HZ            sample rate
  --axes N             axes of the gyro, 1 to {axes} (1)
  --type TYPE          of a sample: int16, int32 or float (int16)
  --lsb X              size of a count in deg/s
  --full-scale X       the largest rate in deg/s, instead of --lsb with --type float
  --bandwidth FILTER   low-pass of the gyro, HZ[:ORDER], or another filter: see --taus --help
  --noise N            typical angle random walk in deg/sqrt(h), to check the size of a count and
                       to state the least bias instability. A noise density of D deg/s/sqrt(Hz) in
                       a data sheet is one-sided: N = 60 D / sqrt(2) = 42.4 D
  --lost PERCENT       of the samples, each reported as a gap: memory for the gaps of a window (1)
  --motion MOTION      slow: ARW also while the gyro turns slowly, on wheels or by hand; none: only
                       at rest, which needs less flash; flight: as none, and a floor per axis,
                       which bounds the noise between rotor lines and motion (slow if --flash and
                       --ram allow it without fewer terms)
  --engine ENGINE      slide: fewer instructions, and no push takes much longer than another; grid:
                       less RAM; small: least flash and RAM, but each lost sample restarts the
                       window: one axis of int16 with --lost 0, --motion none and --bandwidth
                       (the one that needs the least memory)
  --core CORE          {cores}
  --flash BYTES        that davar may use; 24k is 24576
  --ram BYTES          the same, without the stack
  --clock MHZ          of the core, to check that pushes keep up with the samples

What you want
  --respond S          results follow a change of the noise within S seconds ({respond:g})
  --arw-percent P      95 % interval of the angle random walk: +-P percent ({percent:g})
  --longest-tau S      averaging times to at least S seconds, for bias instability and random walk
  --false-alarms-per-hour X
                       an alarm when the noise changes, and X false alarms in an hour

  -o FOLDER            write the files; without it, only print
  --self-contained     with -o: also write davar itself, as davar.c and davar.h, so that FOLDER
                       compiles alone
  --simulate           compile the setup for this machine, run 500 windows of the declared noise,
                       filter and counts, and print what came out
  --json               one JSON object on standard output
  --help

Exit status: 0 done; 1 impossible, with the reason and which wish to relax; 2 bad option (one line
on standard error, nothing written).
"""


def usage() -> str:
    return USAGE.format(
        sensors="NAME:\n" + " " * 23 + f",\n{' ' * 23}".join(
            ", ".join(sorted(sensors.PARTS)[i : i + 6]) for i in range(0, len(sensors.PARTS), 6)
        ),
        axes=wishes.AXES_MOST,
        cores=",\n                       ".join(
            ", ".join(costs.cores()[i : i + 5]) for i in range(0, len(costs.cores()), 5)
        ),
        respond=design.RESPOND_S,
        percent=design.ARW_PERCENT,
    )  # fmt: skip


def write(folder: Path, contents: dict[str, str]) -> None:
    """Writes all files, or none. Raises BadOption."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as new:
            for name, content in contents.items():
                (Path(new) / name).write_text(content, encoding="utf-8")
            for name in contents:
                os.replace(Path(new) / name, folder / name)
    except OSError as why:
        raise BadOption(f"-o: cannot write {why.filename}: {why.strerror}") from None


def files(plan: Plan, command: str, self_contained: bool = False) -> dict[str, str]:
    """Name -> content. command: the one that makes these files; self_contained: with davar."""
    title = f"davar - a setup for {report.subject(plan)}, written by tools/davar-plan."
    library = programs.single_files() if self_contained else None
    about = report.comment(plan, command, self_contained)
    return text.files(plan.design, title, about, library)


def run(words: Sequence[str]) -> int:
    command = wishes.read(words, costs.cores())
    try:
        plan = choice.plan(command.wishes)
    except Impossible as why:
        if command.json:
            print(json.dumps(report.impossible_as_json(why), indent=1))
        else:
            print("davar-plan: " + "\n".join(report.impossible(why)), file=sys.stderr)
        return 1
    found = simulate.simulate(plan) if command.simulate else None
    wrote = "nothing: give a folder with -o to get the C files"
    if command.folder is not None:
        contents = files(plan, "tools/davar-plan " + shlex.join(words), command.self_contained)
        write(Path(command.folder), contents)
        wrote = f"{', '.join(contents)} in {report.printable(command.folder)}"
    if command.json:
        print(json.dumps(report.as_json(plan) | report.simulated_as_json(found), indent=1))
    else:
        print(
            "\n".join(
                [
                    *report.lines(plan),
                    *report.simulated(found, plan.design.law),
                    f"  wrote  {wrote}",
                ]
            )
        )
    return 0


def main() -> int:
    words = sys.argv[1:]
    if "--help" in words or "-h" in words:
        print(usage(), end="")
        return 0
    try:
        return run(words)
    except BadOption as why:
        print(f"davar-plan: {why}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
