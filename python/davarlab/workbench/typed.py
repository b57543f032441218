"""What to type in a terminal for the numbers that the page shows."""

import shlex

from ..data import plausible
from ..effects import own
from ..tables import guess
from . import dataset as datasets
from .steps import Selection, Steps

IMPORTED_NAME, MODEL_NAME = "rec.csv", "model.toml"  # in commands to type


def commands(steps: Steps, selection: Selection) -> list[str]:
    """What to type in a terminal, once the model is saved, for the same numbers; of a stretch
    nothing does."""
    if selection.alone or selection.cut:
        return []
    imported, recording, rate = in_terminal(steps)
    rows = imported + [
        [command, recording, "-m", MODEL_NAME, *rate] for command in ("compare", "fit", "diagnose")
    ]
    return [shlex.join(["tools/davarlab", *row]) for row in rows]


def again(steps: Steps | None, port: int) -> str:
    """What opens the recording once more, on the same port, where its tab finds it."""
    sensor = steps.log.get("sensor") if steps and steps.log else None
    words = [steps.recording] if steps else []
    words += ["--sensor", sensor] if sensor else []
    words += ["--port", str(port), *own.options()]
    return shlex.join(["tools/davarlab", "open", *words])


def in_terminal(steps: Steps) -> tuple[list[list[str]], str, list[str]]:
    """(the import that the log needs, if any, the name of the recording behind it, its --rate,
    --as-recorded and --effects): words to type."""
    renames, scales = (
        datasets.pairs([guess.Guess(**one) for one in steps.log["columns"]])
        if steps.log
        else ([], [])
    )
    sensor = steps.log.get("sensor") if steps.log else None
    sensors = [sensor] if sensor else []
    names = (steps.log.get("names") if steps.log else None) or []
    given = [
        word
        for flag, values in (
            ("--sensor", sensors),
            ("--names", [",".join(names)] if names else []),
            (
                "--skip-lines",
                [str(steps.log["skip"])] if steps.log and steps.log.get("skip") else [],
            ),
            ("--rename", renames),
            ("--scale", scales),
        )
        for value in values
        for word in (flag, value)
    ]
    rate = ["--rate", f"{steps.log['rate_hz']:g}"] if steps.log and steps.log["rate_hz"] else []
    more = [plausible.CONFIRM] if steps.log and steps.log.get("as_recorded") else []
    more += own.options()
    return (
        ([["import", steps.recording, "-o", IMPORTED_NAME, *rate, *given]], IMPORTED_NAME, more)
        if given
        else ([], steps.recording, rate + more)
    )
