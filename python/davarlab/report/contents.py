"""The contents of a report as plain values. The template only arranges them."""

import importlib.metadata
import math
import os
import platform
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from davar import places

from .. import axes, files
from .. import model as models
from ..candidates.candidate import Candidate
from ..data.recording import Recording, as_logged
from ..diagnosis import contributions, evidence, improve, search
from ..diagnosis.compare import Comparison
from ..diagnosis.improve import Estimates, Improvement
from ..diagnosis.state import Judged, State
from ..effects import table
from ..inference.estimate import as_shown
from ..model import Model
from ..thresholds import CHANCE
from . import curves, verdict, words
from .values import Json, plain

VERSION_HEADER = places.shared("lib/include/davar/version.h")
PACKAGES = ("numpy", "scipy", "Jinja2")
WHERE_MAX = 6


@dataclass
class Run:
    """A run: the command as typed, the files and their contents, and the options for further
    commands."""

    typed: list[str]
    recording: Recording
    model: Model
    files: dict[str, str] = field(default_factory=dict)  # role -> path
    common: list[str] = field(default_factory=list)
    output: str | None = None  # the model file that was written
    # Names of recording and model in further commands; None: the file names.
    called: tuple[str, str] | None = None

    @property
    def command(self) -> str:
        return shlex.join(["tools/davarlab", *self.typed])

    def follow_up(self, command: str, *options: str) -> str:
        """Another command on the same files; without a model file, on the same first model."""
        recording, model = self.called or (self.files["recording"], self.files.get("model"))
        files = [recording, *(["-m", model] if model else [])]
        return shlex.join(["tools/davarlab", command, *files, *self.common, *options])


def versions() -> dict[str, str]:
    found = {
        "davar": ".".join(
            re.findall(r"#define DAVAR_VERSION_\w+ (\d+)", VERSION_HEADER.read_text())
        ),
        "Python": platform.python_version(),
    }
    return {**found, **{name: importlib.metadata.version(name) for name in PACKAGES}}


def file_facts(given: Mapping[str, str]) -> list[Json]:
    """Path, size and SHA-256, which identify the file."""
    rows = []
    for role, path in given.items():
        parts = (
            sorted(one for one in Path(path).iterdir() if one.is_file())
            if os.path.isdir(path)
            else [path]
        )  # a ROS bag can be a folder: list each file
        rows += [
            {
                "role": role,
                "name": Path(one).name,
                "path": str(one),
                "bytes": os.path.getsize(one),
                "sha256": files.sha256(one),
            }
            for one in parts
        ]
    return rows


def run_facts(run: Run) -> Json:
    recording = run.recording
    return {
        "command": run.command,
        "files": file_facts(run.files),
        "samples": recording.measured_samples,
        "missing": recording.samples - recording.measured_samples,
        "rate_hz": recording.rate_hz,
        "duration_s": recording.samples / recording.rate_hz,
        "gaps": len(recording.gaps),
        "column": as_logged(run.model.column),
        "notes": recording.notes,
        "columns": list(map(as_logged, recording.columns)),
        "versions": versions(),
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def parameter_rows(model: Model, given: Model, estimates: Sequence[Estimates]) -> list[Json]:
    """One row per parameter: the value in the model file (None: absent), the fitted value and its
    95 % interval."""
    before = {term.kind: term.parameters for term in given.terms}
    rows: list[Json] = []
    for place, (term, entry) in enumerate(zip(model.terms, estimates)):
        for index, parameter in enumerate(
            p for p in table.find(term.kind).parameters if p.name in entry
        ):
            name = models.name_said(parameter.name, model.column)
            unit = models.unit_said(parameter.unit, model.column)
            rows.append(
                {
                    "effect": words.named(term.kind, model.column),
                    "first": index == 0,
                    "name": name,
                    "key": f"fitted.{place}.parameters.{name}",
                    "unit": "" if parameter.values or parameter.form else unit,
                    "given": before.get(term.kind, {}).get(parameter.name),
                    "fitted": entry[parameter.name],
                    "new": term.kind not in before,
                }
            )
    return rows


def candidate_rows(found: Improvement) -> tuple[list[Json], list[str], list[str]]:
    """(candidates to show, names of those that only imitate an added effect, names of those that
    are not significant)."""
    count, added = len(found.candidates), found.added
    shown: list[Json] = []
    imitators: list[str] = []
    chance: list[str] = []
    remaining = (
        {candidate.kind: math.exp(candidate.log_p) for candidate in found.diagnosis.remaining}
        if added
        else {}
    )
    fitted = dict(zip(found.model.kinds, found.estimates))
    for index, candidate in enumerate(found.candidates):
        kind, after = candidate.kind, remaining.get(candidate.kind)
        joined, lasting = kind in added, after is not None and after * count < CHANCE.family_wise
        if joined or lasting or candidate.parameters and candidate.p_value < 0.05:
            weight = words.evidence(
                candidate.p_value,
                after,
                count,
                joined,
                kind in [one.kind for one in found.diagnosis.alternatives],
            )
            shown.append(
                {
                    "index": index,
                    "candidate": candidate,
                    "name": words.name(kind),
                    "added": joined,
                    "evidence": weight,
                    "effect": table.find(kind),
                    "after": None if joined else after,
                    "share": evidence.share(candidate.error_after, found.base),
                    "strength": words.strength(
                        kind,
                        as_shown(
                            [candidate.parameters or fitted.get(kind, {})],
                            found.judgement.adequate,
                        )[0],
                        found.model.column,
                    ),
                }
            )
        else:
            (imitators if candidate.p_value * count < CHANCE.family_wise else chance).append(
                words.name(kind)
            )
    return shown, imitators, chance


def test_rows(given: Comparison, better: Comparison | None) -> list[Json]:
    return [
        {
            "name": name,
            "what": verdict.TESTS.get(name, ""),
            "p": p,
            "after": better.tests.get(name) if better else None,
        }
        for name, p in given.tests.items()
    ]


def correlation_rows(given: Comparison, better: Comparison | None) -> list[Json]:
    after = better.correlations if better else {}
    return [
        {"name": name, "value": value, "p": p, "after": after.get(name, (None, None))[0]}
        for name, (value, p) in sorted(
            given.correlations.items(), key=lambda item: -abs(item[1][0])
        )
    ]


def measured(
    run: Run,
    comparison: Comparison,
    better: Comparison | None,
    state: State,
    model: Model,
    estimates: Sequence[Estimates],
) -> Json:
    """The part that every report has. better: the comparison of the final model, if it has more
    effects than the initial one. state, model, estimates: the final model on this recording."""
    return {
        "run": run_facts(run),
        "gap_note": words.gap_note(run.recording),
        "notes": [verdict.observation(one) for one in comparison.observations]
        + evidence.notes(run.recording, run.model),
        "given_names": [words.named(kind, run.model.column) for kind in run.model.kinds],
        "comparison": comparison,
        "better": better,
        "misfit": verdict.misfit(comparison),
        "failed": verdict.failed_tests((better or comparison).tests),
        "where": comparison.where[:WHERE_MAX],
        "tests": test_rows(comparison, better),
        "correlations": correlation_rows(comparison, better),
        "parameters": parameter_rows(model, run.model, estimates),
        "model_text": models.text_of(axes.called(model, as_logged(model.column))),
        "drawn": drawn(run, comparison, better, state, zip(model.kinds, estimates)),
    }


def drawn(
    run: Run,
    given: Comparison,
    better: Comparison | None,
    state: State,
    effects: Iterable[tuple[str, Estimates]],
) -> Json:
    """What drawing.js draws. effects: of the final model, with their estimates."""
    recording, last = run.recording, better or given
    compared = {"initial": given} | ({"final": better} if better else {})
    before = curves.deviation(given.cells, [])
    parts = contributions.of_state(state) if better else []
    found: Json = plain(
        {
            "span_s": recording.samples / recording.rate_hz,
            "unit": given.unit,
            "deviation": curves.deviation(last.cells, parts),
            "before": before["curve"] if better else None,
            "maps": {name: curves.failure_map(one.cells) for name, one in compared.items()},
            "spectra": {
                f"{name} model": curves.residual(*one.spectrum) for name, one in compared.items()
            },
            "columns": [
                curves.envelope(name, recording.column(name), recording.rate_hz)
                for name in columns_drawn(recording, run.model.column)
            ],
            "marked": marked(state, effects),
            "steps": [],
        }
    )
    return found


def columns_drawn(recording: Recording, gyro: str) -> list[str]:
    """The gyro, and the columns beside it that change."""
    others = [
        name
        for name, values in recording.columns.items()
        if name != "time_s" and not name.startswith("gyro_") and np.ptp(values) > 0
    ]
    return [gyro, *[name for name in others if name != gyro][: curves.COLUMNS]]


def marked(state: State, effects: Iterable[tuple[str, Estimates]]) -> list[tuple[float, float]]:
    """Stretches (s) of noise steps, and shocks."""
    found = []
    for kind, entry in effects:
        if kind == "noise_step":
            found.append((float(entry["start_s"].value), float(entry["stop_s"].value)))
        if kind == "shocks":
            rate_hz = state.bench.data.rate_hz
            found += [(time / rate_hz, time / rate_hz) for time in state.shocks.times]
    return found


def tried_rows(ranked: Sequence[Candidate]) -> list[Json]:
    """The effects that were tried beside a model, and are not in it."""
    return [
        {
            "name": words.title(one.kind, one.part.shape),
            "significant": search.significant([one]),
            "gain": one.gain,
            "p": math.exp(one.log_p),
            "physics": one.part.effect.physics,
        }
        for one in ranked
    ]


def of_comparison(
    run: Run,
    comparison: Comparison,
    state: Judged,
    way: Sequence[Json] = (),
    first: Comparison | None = None,
    ranked: Sequence[Candidate] = (),
) -> Json:
    """`davarlab compare`, and the report of a session. state: the model refitted on the recording.
    way: label, error, floor, verdict and held-out error of the steps to the model; first: the
    model of the first step, if later ones added effects to it; ranked: the candidates beside the
    model."""
    tone, said = verdict.of_comparison(comparison, evidence.contradicting(ranked))
    before, better = (first, comparison) if first else (comparison, None)
    contents = {
        **measured(run, before, better, state, *improve.fitted_model(state, run.model)),
        "misfit": verdict.misfit(comparison),
        "story": list(way),
        "tried": tried_rows(ranked),
        "title": "Model and measurement",
        "tone": tone,
        "verdict": said,
        "next": verdict.after_comparison(comparison, state, run),
    }
    contents["drawn"]["steps"] = list(way)
    return contents


def of_improvement(run: Run, found: Improvement) -> Json:
    """`davarlab diagnose` and `davarlab improve`."""
    assert found.state is not None  # improve.improved() gives it
    better = found.comparisons[-1] if len(found.comparisons) > 1 else None
    tone, said = verdict.of_improvement(found)
    shown, imitators, chance = candidate_rows(found)
    contents = {
        **measured(run, found.comparison, better, found.state, found.model, found.estimates),
        "notes": [verdict.observation(one) for one in found.comparison.observations] + found.notes,
        "title": "Missing effects",
        "tone": tone,
        "verdict": said,
        "excluded": verdict.excluded(found.unexplained) if found.unexplained else [],
        "checks_after": verdict.checks_after(found.judgement.p_value),
        "found": found,
        "improvement": verdict.improvement(found),
        "next": verdict.what_next(found, run),
        "p_value_after": found.judgement.p_value,
        "candidates": shown,
        "imitators": imitators,
        "chance_kinds": chance,
        "added": words.listed(found.added) if found.added else None,
        "steps": found.steps,
    }
    contents["drawn"]["steps"] = [
        {
            "label": "Initial model" if step.added is None else f"+ {words.name(step.added)}",
            "error": step.error,
            "floor": step.error_floor,
            "fits": step.adequacy != "no",
        }
        for step in found.steps
    ]
    return contents
