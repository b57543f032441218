"""Runs one proof of this folder with Eva, the abstract interpreter of Frama-C, and reads its
output. Standard library only.

Manual use: proving.py NAME [-DBOUND=NUMBER ...], from any folder. It prints the alarms and exits
with status 1 if one is not in alarms.txt.
"""

import os
import re
import shlex
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import amalgamate

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]

MANIFEST = [path.relative_to(ROOT).as_posix() for path in amalgamate.SOURCES]
# The pipelines: the sources of a stream.
STREAM = tuple(
    name
    for name in MANIFEST
    if name.startswith("lib/") and name.split("/")[2] not in ("filter", "fit")
)
# sources: in addition to prove_NAME.c; unroll: the largest number of loop iterations that are
# followed one by one; more: options.
Proof = namedtuple("Proof", "sources unroll more", defaults=(300, ()))
PROOFS = {
    "decode": Proof(
        ("addons/can/src/decode.c", "addons/can/src/encode.c"),
        more=("-eva-split-return-function", "davar_decode:0"),
    ),
    "slcan": Proof(("addons/can/src/slcan.c",)),
    "number": Proof(
        tuple(f"lib/src/number/{name}.c" for name in ("machine", "real", "scaled"))
        + ("lib/src/laws/logarithm.c",)
    ),
    "slide": Proof((), 5000),
    "restore": Proof(
        (*STREAM, "addons/state/src/image.c", "addons/state/src/state.c"),
        1100,
        ("-eva-split-return-function", "davar_init_wide:0"),
    ),
    "push": Proof(STREAM, more=("-eva-split-return-function", "davar_init_wide:0")),
}
OPTIONS = shlex.split(
    "-c11 -eva -main prove -machdep gcc_x86_64 -warn-invalid-pointer -warn-special-float none "
    "-eva-slevel 50 -eva-split-return auto -eva-msg-key=-final-states,-initial-state "
    "-kernel-warn-key typing:implicit-conv-void-ptr=inactive"
)
# Functions without code and without a contract: Eva assumes correctly that they change nothing.
WITHOUT_CODE = {"atomic_thread_fence"}


def alarms_of(output):
    """(file, Eva's message) of every alarm in its output, without line numbers."""
    found = re.findall(
        r"^\[eva:alarm\] (\S+?):\d+: Warning: *\n((?:  .*\n)+)", output, re.MULTILINE
    )
    return {(name, " ".join(text.split())) for name, text in found}


def listed(name):
    """The alarms of alarms.txt for one proof."""
    rows = [
        line.split(" | ")
        for line in (HERE / "alarms.txt").read_text().splitlines()
        if line and not line.startswith("#")
    ]
    assert all(len(row) == 4 and all(row) for row in rows), (
        "alarms.txt: proof | file | Eva's message | reason"
    )
    return {(file, text) for proof, file, text, _ in rows if proof == name}


def prove(name, bounds=(), root=ROOT):
    """Runs prove_NAME.c with the sources below `root`. Returns (alarms, Eva's output).
    RuntimeError: nothing was proved.
    """
    proof = PROOFS[name]
    # Eva has no 128-bit integer: the compiler's is hidden, and davar computes its products by
    # parts.
    parts = [f"-I{path.relative_to(ROOT)}" for path in sorted(ROOT.glob("addons/*/*/"))]
    flags = " ".join(
        ("-Ilib/include", "-Ilib/src", *parts, f"-I{HERE}")
        + ("-DDAVAR_PORTABLE", "-U__SIZEOF_INT128__", *bounds)
    )
    command = ["frama-c", *OPTIONS, *proof.more, "-eva-auto-loop-unroll", str(proof.unroll)]
    command += [f"-cpp-extra-args={flags}", str(HERE / f"prove_{name}.c"), *proof.sources]
    done = subprocess.run(
        command,
        cwd=root,
        env={**os.environ, "PWD": str(root)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    without = (
        set(re.findall(r"Neither code nor specification for function (\w+)", done.stdout))
        - WITHOUT_CODE
    )
    alarms = alarms_of(done.stdout)
    if done.returncode or without or "[eva:summary]" not in done.stdout:
        raise RuntimeError(
            f"{name}: no proof; without code: {sorted(without)}\n{done.stdout[-3000:]}"
        )
    if not alarms and "Frama_C_show_each_proved" not in done.stdout:
        raise RuntimeError(f"{name}: the end of the proof is not reached\n{done.stdout[-3000:]}")
    return alarms, done.stdout


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in PROOFS:
        print(f"usage: proving.py {'|'.join(PROOFS)} [-DBOUND=NUMBER ...]", file=sys.stderr)
        return 2
    alarms, _ = prove(sys.argv[1], sys.argv[2:])
    new = alarms - listed(sys.argv[1])
    for file, text in sorted(alarms):
        print(f"{'new' if (file, text) in new else 'listed'}: {file}: {text}")
    print(f"{sys.argv[1]}: {len(new)} new alarms, {len(alarms) - len(new)} listed")
    return 1 if new else 0


if __name__ == "__main__":
    sys.exit(main())
