"""Which physical effect is missing: the search, and what it comes to."""

from dataclasses import dataclass, field

from . import search
from .state import start


@dataclass
class Diagnosis:
    """verdict: a kind, "none" or "unknown"; ranking: candidates for the model as given (its shapes refitted), best first;
    added: the kinds that forward selection took, in order; states: the model before and after each of them; remaining:
    candidates beside the last model; useless: those of them that are likelier than chance and leave the error where it was."""
    verdict: str
    ranking: list
    alternatives: list
    added: list = field(default_factory=list)
    states: list = field(default_factory=list)
    remaining: list = field(default_factory=list)
    useless: list = field(default_factory=list)


def close_ones(found):
    """Kinds that this recording cannot tell from the first."""
    return [c.kind for c in found[1:] if c.log_p - found[0].log_p < search.CLOSE and c.gain > 0]


def diagnose(recording, model, progress=lambda text: None):
    """Forward selection from the given model. Cost: one to three seconds at 360 000 samples."""
    given = len(model.terms)
    states, first, useless, found = search.search(start(recording, model, progress), given, progress)
    added = [part.kind for part in states[-1].parts[given:]]
    verdict = "unknown" if not states[-1].judgement.adequate else next((c.kind for c in first if c.kind in added), "none")
    close = close_ones(first) if search.significant(first) else []
    return Diagnosis(verdict, first, close, added, states, found, useless)
