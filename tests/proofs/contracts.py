"""Proves with WP, of Frama-C, that functions of the library keep their contracts. The contracts are
in contract_NAME.c; contract_NAME.patch puts assertions into a copy of the library. Standard library
only.

Manual use: contracts.py NAME [-DBOUND=NUMBER ...], from any folder. It prints the goals that were
not proved and exits with status 1 if there is one.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CONTRACTS = {"slide": ("sum_slide", "slide_any", "slide_octaves")}
STEPS = 10_000_000  # of a prover for each goal: the same on a busy machine
OPTIONS = shlex.split(
    "-c11 -machdep gcc_x86_64 -wp -wp-rte -wp-model Typed+Cast -wp-prover z3,cvc4 -wp-timeout 3600 "
    f"-wp-par {os.cpu_count()} -wp-warn-key pedantic-assigns=inactive "
    "-kernel-warn-key typing:implicit-conv-void-ptr=inactive"
)


def run(command, **more):
    """Its output. RuntimeError: a status that is not 0."""
    done = subprocess.run(
        command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}")
    return done.stdout


def unproved(name, bounds=(), fault=None, only=(), steps=STEPS):
    """The goals of contract_NAME.c that were not proved, and the number of all goals. fault: (file,
    text, other text), injected after the assertions; only: names of assertions, instead of all.
    """
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "lib", f"{folder}/lib")
        run(["git", "apply", str(HERE / f"contract_{name}.patch")], cwd=folder)
        if fault:
            source = Path(folder, fault[0])
            before = source.read_text()
            assert before.count(fault[1]) == 1, fault
            source.write_text(before.replace(*fault[1:]))
        variables = {**os.environ, "PWD": folder, "WHY3CONFIG": f"{folder}/why3.conf"}
        run(["why3", "config", "detect"], env=variables)
        # Neither WP nor Eva has an integer of 128 bits: the compiler's is hidden.
        flags = " ".join(
            ("-Ilib/include", "-Ilib/src", "-DDAVAR_PORTABLE", "-U__SIZEOF_INT128__", *bounds)
        )
        command = ["frama-c", *OPTIONS, "-wp-steps", str(steps), f"-cpp-extra-args={flags}"]
        command += ["-wp-fct", ",".join(CONTRACTS[name])]
        command += ["-wp-prop", ",".join(only)] if only else []
        output = run([*command, str(HERE / f"contract_{name}.c")], cwd=folder, env=variables)
    counts = re.search(r"^\[wp\] Proved goals: +(\d+) / (\d+)$", output, re.MULTILINE)
    failed = re.findall(r"^\[wp\] \[Failed\] Goal (\w+)", output, re.MULTILINE)
    if not counts or int(counts[2]) - int(counts[1]) != len(failed) or not int(counts[2]):
        raise RuntimeError(f"{name}: no result\n{output[-3000:]}")
    return failed, int(counts[2])


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in CONTRACTS:
        print(f"usage: contracts.py {'|'.join(CONTRACTS)} [-DBOUND=NUMBER ...]", file=sys.stderr)
        return 2
    failed, goals = unproved(sys.argv[1], sys.argv[2:])
    for goal in failed:
        print(f"not proved: {goal}")
    print(f"{sys.argv[1]}: {goals - len(failed)} of {goals} goals proved")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
