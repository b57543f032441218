"""The C sources of the library, core and parts, and the folders of its headers, for tools and tests
that compile them. Standard library only.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Folders of the public headers; each has a folder davar.
PUBLIC = [ROOT / "lib/include", *sorted(ROOT.glob("addons/*/include"))]
SOURCES = sorted([*(ROOT / "lib/src").rglob("*.c"), *ROOT.glob("addons/*/src/*.c")])
# What a program that uses the library needs, and what its sources need.
PROGRAM_FLAGS = [f"-I{folder}" for folder in PUBLIC]
FLAGS = [*PROGRAM_FLAGS, f"-I{ROOT / 'lib/src'}"]
