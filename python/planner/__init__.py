"""The planner: from wishes in physical units to a setup of davar in C, its costs and its promises.

The modules in the order of the data: wishes (with sensors), design, promises (with programs),
costs, choice, text, report. Standard library only.
"""

from typing import Any

from . import choice, report
from .choice import Impossible
from .wishes import BadOption, Wishes, checked

__all__ = ["BadOption", "Impossible", "Wishes", "plan"]


def plan(**wishes: Any) -> dict[str, Any]:
    """The plan for wishes by the names of the fields of Wishes, as --json gives it.
    Raises BadOption and Impossible."""
    return report.as_json(choice.plan(checked(Wishes(**wishes))))
