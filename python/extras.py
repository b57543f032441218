"""The extra lab of the Python distribution: reads the pins of tools/requirements-lab.txt for
scikit-build-core (pyproject.toml).
"""

from pathlib import Path


def dynamic_metadata(field, settings, project=None):
    """Called by scikit-build-core in the folder of pyproject.toml."""
    lines = Path("tools/requirements-lab.txt").read_text(encoding="utf-8").splitlines()
    return {"lab": [line for line in map(str.strip, lines) if line and not line.startswith("#")]}
