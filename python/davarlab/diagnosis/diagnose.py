"""Which physical effect is missing: the search, and what it comes to."""

from dataclasses import dataclass, field, replace

from ..candidates.candidate import Candidate
from ..candidates.identifiable import Alternative
from ..data.recording import Recording
from ..inference.parts import Part
from ..model import Model
from . import evidence, search
from .fitting import start
from .state import Judged, Progress


@dataclass
class Diagnosis:
    """verdict: a kind, "none" or "unknown"; ranking: candidates for the model as given (its shapes
    refitted), best first; alternatives: what the recording cannot tell from what was named, and how
    to find out (identifiable.Alternative); added: the kinds that forward selection took, in order;
    states: the model before and after each of them; remaining: candidates beside the last model;
    useless: parts that are likelier than chance and leave the error where it was; doubtful: kinds
    of what was beyond chance and is not named, and why; outdone: kinds that joined and left
    again, because later ones explain them; ended: the bound that ended the search before
    everything was tried ("24 steps"), or empty; against: what speaks against a last model that
    fits, beside it."""

    verdict: str
    ranking: list[Candidate]
    alternatives: list[Alternative]
    added: list[str] = field(default_factory=list)
    states: list[Judged] = field(default_factory=list)
    remaining: list[Candidate] = field(default_factory=list)
    useless: list[Part] = field(default_factory=list)
    doubtful: dict[str, str] = field(default_factory=dict)
    outdone: list[str] = field(default_factory=list)
    ended: str = ""
    against: list[Candidate] = field(default_factory=list)


def diagnose(
    recording: Recording, model: Model, progress: Progress = lambda text: None
) -> Diagnosis:
    """Forward selection from the given model. Cost: one to three seconds at 360 000 samples."""
    states, way, useless = search.search(start(recording, model, progress), model, progress)
    added = [part.kind for part in states[-1].parts[way.given :]]
    adequate = states[-1].judgement.adequate
    verdict = (
        "unknown"
        if not adequate
        else next((c.kind for c in way.first if c.kind in added), added[0] if added else "none")
    )
    return Diagnosis(
        verdict,
        list(way.first),
        list(way.alternatives),
        added,
        states,
        list(way.last),
        useless,
        dict(way.doubtful),
        sorted(way.outdone - set(states[-1].model_kinds)) if added else [],
        way.ended,
        left_out(states[-1], way, [part.kind for part in useless]) if adequate else [],
    )


def left_out(last: Judged, way: search.Search, useless: list[str]) -> list[Candidate]:
    """What the search left out for another reason than chance, if the last model lacks it."""
    kinds = {*useless, *way.doubtful, *(one.kind for one in evidence.contradicting(way.last))}
    found = evidence.contradicting(search.ranking(last, only=kinds)) if kinds else []
    return [replace(one, doubt=search.doubt(last, one)) for one in found]
