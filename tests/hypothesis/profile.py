"""The number of examples of a property. In tools/test there are few, always the same.
DAVAR_HYPOTHESIS=N gives N times as many, drawn at random.
"""

import os
from pathlib import Path

os.environ.setdefault(
    "HYPOTHESIS_STORAGE_DIRECTORY",
    str(Path(__file__).resolve().parents[2] / "build/cache/hypothesis"),
)

from hypothesis import HealthCheck, settings

TIMES = int(os.environ.get("DAVAR_HYPOTHESIS", "1"))


def examples(count):
    """Settings of a property with this number of examples in tools/test."""
    return settings(
        max_examples=count * TIMES,
        derandomize=TIMES == 1,
        database=None,
        deadline=None,
        print_blob=False,
        suppress_health_check=list(HealthCheck),
    )
