"""How many examples a property gets. In tools/test they are few and the same ones every time; DAVAR_HYPOTHESIS=N gives each N times as many, drawn anew."""

import os
from pathlib import Path

os.environ.setdefault(
    "HYPOTHESIS_STORAGE_DIRECTORY",
    str(Path(__file__).resolve().parents[2] / "build/cache/hypothesis"),
)

from hypothesis import HealthCheck, settings  # noqa: E402

TIMES = int(os.environ.get("DAVAR_HYPOTHESIS", "1"))


def examples(count):
    """The settings of a property with so many examples in tools/test."""
    return settings(
        max_examples=count * TIMES,
        derandomize=TIMES == 1,
        database=None,
        deadline=None,
        print_blob=False,
        suppress_health_check=list(HealthCheck),
    )
