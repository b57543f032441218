"""What --json says, and the page of the workbench: plain values."""

import math
from collections.abc import Sequence
from typing import Any

from ..data.observations import Observation
from ..diagnosis.compare import Comparison
from ..diagnosis.improve import Estimates, Improvement
from ..diagnosis.judge import Judgement
from ..diagnosis.unexplained import Unexplained
from ..inference.estimate import superfluous
from ..model import Model
from . import verdict, words

Json = dict[str, Any]  # an object of JSON


def plain(value: Any) -> Any:
    """JSON has no infinity and no NaN."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def estimates(entries: Estimates) -> Json:
    return {
        name: {"value": e.value, "low": e.low, "high": e.high}
        | ({"undetermined": True} if e.undetermined else {})
        for name, e in entries.items()
    }


def fitted(model: Model, entries: Sequence[Estimates], adequate: bool) -> list[Json]:
    return [
        {
            "kind": term.kind,
            "parameters": estimates(entry),
            "superfluous": adequate and superfluous(term.kind, entry),
        }
        for term, entry in zip(model.terms, entries)
    ]


def judgement(j: Judgement) -> Json:
    return {
        "adequacy": j.adequacy,
        "adequate": j.adequate,
        "largest_deviation": j.largest,
        "shown_to_tau_s": j.shown_to_tau_s,
        "arw_reading": None
        if j.reading is None or j.reading.model == 0
        else {"ratio": j.reading.ratio, "least": math.exp(j.reading.off)},
        "said": words.in_ascii(verdict.adequacy(j)),
    }


def unexplained(found: Unexplained | None) -> Json | None:
    """Where a model fails that no effect explains, what was excluded, and what to do next."""
    if found is None:
        return None
    return {
        "where": {
            **found.deviation,
            "frequency_hz": found.frequency_hz,
            "power_ratio": found.power,
            "column": found.column,
            "correlation": found.correlation,
        },
        "excluded": [vars(one) for one in found.excluded],
        "not_tested": {kind: list(needs) for kind, needs in found.untested.items()},
        "next": [words.in_ascii(line) for line in verdict.next_steps(found)],
    }


def answered(found: Improvement) -> Json:
    """What a diagnosis or an improvement comes to, in words too."""
    return {
        "verdict": found.verdict,
        "intervals_hold": found.judgement.adequate,
        "answer": verdict.answer(found),
        "answer_said": words.in_ascii(verdict.of_improvement(found)[1]),
        "unknown": unexplained(found.unexplained),
        "alternatives": [vars(one) for one in found.diagnosis.alternatives],
        "against": [
            {
                "kind": one.kind,
                "p_value": verdict.p_of(one),
                "said": words.in_ascii(verdict.counter(one)),
            }
            for one in found.against
        ],
        "useless": [part.kind for part in found.diagnosis.useless],
        "doubtful": found.diagnosis.doubtful,
        "outdone": found.diagnosis.outdone,
        "missing": found.added,
        "missing_said": words.in_ascii(verdict.missing(found)),
    }


def observations(seen: Sequence[Observation]) -> list[Json]:
    return [one.plain() for one in seen]


def observed(found: Improvement) -> list[Json]:
    """The observations on a recording, and what an unknown effect leaves unexplained."""
    seen, left = list(found.comparison.observations), found.unexplained
    if left is not None:
        start, stop = left.deviation["start_s"], left.deviation["stop_s"]
        said = " ".join([verdict.of_unknown(found), *verdict.next_steps(left)])
        share = (stop - start) / left.duration_s
        seen.append(Observation("unknown", [[start, stop]], share, words.in_ascii(said)))
    return observations(seen)


def comparison(c: Comparison) -> Json:
    return {
        "samples": c.samples,
        "samples_missing": c.missing,
        "rate_hz": c.rate_hz,
        "effects": c.effects,
        "error": c.error,
        "error_floor": c.error_floor,
        "p_value": c.p_value,
        **judgement(c.judgement),
        "observations": observations(c.observations),
        "tests": c.tests,
        "correlations": {
            name: {"value": r, "p_value": p} for name, (r, p) in c.correlations.items()
        },
        "where": [
            {
                "tau_s": w.tau_s,
                "start_s": w.start_s,
                "stop_s": w.stop_s,
                "measured_dps": w.measured_dps,
                "model_dps": w.model_dps,
                "ratio": w.ratio,
                "z": w.z,
            }
            for w in c.where
        ],
    }


def diagnosis(found: Improvement) -> Json:
    return {
        **comparison(found.comparison),
        **answered(found),
        "observations": observed(found),
        "final": judgement(found.judgement),
        "steps": [vars(step) for step in found.steps],
        "refitted": found.refitted and vars(found.refitted),
        "notes": found.notes,
        "fitted": fitted(found.model, found.estimates, found.judgement.adequate),
        "p_value_after": found.judgement.p_value,
        "candidates": [
            {
                "kind": c.kind,
                "gain": c.gain,
                "p_value": c.p_value,
                "error_after": c.error_after,
                "error_held_out_after": c.error_held_out_after,
                "parameters": estimates(c.parameters),
                "why": c.why,
            }
            for c in found.candidates
        ],
    }


def improvement(found: Improvement, output: str | None) -> Json:
    return {
        "steps": [vars(step) for step in found.steps],
        "refitted": found.refitted and vars(found.refitted),
        **answered(found),
        **judgement(found.judgement),
        "observations": observed(found),
        "notes": found.notes,
        "model": output,
        "fitted": fitted(found.model, found.estimates, found.judgement.adequate),
    }
