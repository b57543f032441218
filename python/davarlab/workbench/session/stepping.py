"""The steps of a session: which one is current, what is beside it, and what leads to another
one."""

import contextlib
import hashlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from ... import model as models
from ...candidates.candidate import Candidate
from ...errors import BadInput
from ...model import Model
from ...report import words
from ...report.values import Json
from .. import schema, views
from ..dataset import Dataset, Outcome
from ..schema import Number, Place, Text, Values
from ..steps import Step, Steps, fit_of
from .standing import Stale, Standing, Wish

OfKind = TypeVar("OfKind", Candidate, models.Term)


class Superseded(Exception):
    """What was being computed is not wanted now."""


class Stepping:
    """Takes the steps of a session."""

    def __init__(self, session: Standing) -> None:
        self.session = session

    def here(self, number: int | None = None) -> Step:
        """The current step; `number`: that step."""
        steps = self.session.open_steps
        return steps.here if number is None else steps.steps[self.known(number)]

    def state(self, step: Step | None = None) -> str:
        """Names what a page shows: the recording, the selection of it, the step and its model."""
        step = step or self.here()
        return hashlib.sha256(
            "\0".join(
                [
                    str(self.session.open_steps.path),
                    self.session.open_steps.seen,
                    str(step.number),
                    step.text,
                ]
            ).encode()
        ).hexdigest()[:16]

    def current(self, state: str) -> Step:
        """The current step, if it is the one that the page showed. Raises Stale."""
        step = self.here()
        if state != self.state(step):
            raise Stale(
                "this was shown for another axis, stretch or step; nothing was changed, look at "
                "the page as it is now and try again"
            )
        return step

    def shown(self, number: int | None, state: str | None) -> Step:
        """The step that the page showed, where it says so (`state`); else the current one, or that
        of the number."""
        return self.here(number) if state is None else self.current(state)

    def known(self, number: int) -> int:
        if not 0 <= number < len(self.session.open_steps.steps):
            raise BadInput(f"there is no step {number}")
        return number

    def outcome(self, step: Step) -> Outcome:
        return self.session.open_dataset.outcome_of(step.text, step.fitted, self.session.progress)

    def held_out(self, step: Step) -> tuple[float | None, float | None]:
        """The error of a step on the recording that is held out, and its floor."""
        return self.session.open_dataset.held_out(
            step.text, self.outcome(step).model, self.session.held
        )

    def grown(
        self,
        steps: Steps,
        dataset: Dataset,
        did: str,
        outcome: Outcome,
        fitted: bool = True,
        **more: Any,
    ) -> None:
        """A new step. Its model file is that of the fitted values, so that a terminal gives the
        same."""
        if fitted:
            dataset.keep(outcome)
        judgement = outcome.state.judgement
        steps.grow(
            did,
            dataset.called(outcome.model),
            fitted=fitted,
            error=judgement.error,
            floor=judgement.floor,
            rejected=bool(judgement.spoiled_by),
            **more,
        )

    def grow(self, did: str, outcome: Outcome, **more: Any) -> Json:
        self.grown(self.session.open_steps, self.session.open_dataset, did, outcome, **more)
        return self.session.changed()

    def fit(self, model: Model) -> Outcome:
        dataset = self.session.open_dataset
        return dataset.outcome_of(dataset.text(model), True, self.session.progress)

    def step(self, number: Place | None = None) -> Json:
        """A step as the page draws it."""
        step = self.here(number)
        outcome = self.outcome(step)
        return {
            "number": step.number,
            "state": self.state(step),
            "did": step.did,
            "fitted": step.fitted,
            "off": step.off,
            **views.model(outcome, self.session.open_dataset.recording, step.parent is None),
        }

    def candidates(self, number: Place | None = None) -> Json:
        """The ranking beside a step, or beside the fit that its values by hand came from; given up,
        and said so, when somebody does something or holds a slider."""
        step = self.here(number)
        state, text = self.state(step), self.fitted_step(step).text

        def partly(kind: str, found: Sequence[Candidate | None]) -> None:
            self.give_way()
            so_far = sorted(filter(None, found), key=lambda candidate: candidate.log_p)
            self.session.tell(
                ranking=state, trying=words.name(kind), candidates=views.candidates(so_far)
            )

        dataset = self.session.open_dataset
        try:
            ranked = dataset.ranked(text, self.session.progress, partly, self.give_way)
            outcome = dataset.outcome_of(text, True, self.session.progress)
            found = {
                "number": step.number,
                "state": state,
                **views.ranking(outcome, dataset.recording, ranked),
            }
            fits = self.outcome(step).state.judgement.adequate and not found["against"]
            with contextlib.suppress(BadInput):  # another process has the file: an action says so
                self.session.open_steps.settle(step.number, fits)
            return found
        except Superseded:
            return {"number": step.number, "state": state, "superseded": True}

    def wanted(
        self, step: Step, place: int, kind: str, also: int | None, also_kind: str
    ) -> list[Candidate]:
        """The candidate of a place, and the one that is to join with it."""
        text = self.fitted_step(step).text
        ranked = self.session.open_dataset.ranked(text, self.session.progress)
        given = [(place, kind)] + ([] if also is None else [(also, also_kind)])
        for one, _ in given:
            if one >= len(ranked):
                raise BadInput(f"there is no candidate {one}")
        return [self.of_kind(ranked[one], kind) for one, kind in given]

    @staticmethod
    def of_kind(found: OfKind, kind: str) -> OfKind:
        """What stands at a place, if it is of the kind that the page showed there. Raises Stale."""
        if found.kind != kind:
            raise Stale(
                f"{words.name(found.kind)} stands there now, not {words.name(kind)}; nothing was "
                "changed"
            )
        return found

    def give_way(self, but: Wish | None = None) -> None:
        """Raises Superseded when somebody does something else than `but`, or holds a slider."""
        if self.session.superseded(but):
            raise Superseded

    def candidate_preview(
        self, place: Place, kind: Text, state: Text, also: Place | None = None, also_kind: Text = ""
    ) -> Json:
        """The curve and the error with a candidate, or with two, before they are added; given up as
        the ranking is, and when the page shows an older step, but not for Add, which takes the
        result."""
        given: Json = {"place": place, "kind": kind, "state": state}
        same = "add", given if also is None else {**given, "also": also, "also_kind": also_kind}
        try:
            step = self.current(state)
            wanted = self.wanted(step, place, kind, also, also_kind)
            found = self.joined(step, wanted, lambda: self.give_way(same))
        except (Superseded, Stale):
            return {"superseded": True}
        judgement = found.state.judgement
        return {
            "deviation": views.deviation(found),
            "error": judgement.error,
            "floor": judgement.floor,
        }

    def preview(self, place: Place, kind: Text, name: Text, value: Number, state: Text) -> Json:
        """The curve with one value moved, while a slider is held."""
        step = self.current(state)
        model = self.moved(step, place, kind, {name: value})
        return views.preview(self.session.open_dataset.given(self.best(step), model))

    def without(self, place: Place, kind: Text, state: Text) -> Json:
        """What the fit of a step loses without an effect."""
        step = self.current(state)
        self.of_kind(self.term(models.of_text(step.text, "model"), place), kind)
        return views.without(self.outcome(step), place)

    def moved(
        self, step: Step, place: int, kind: str, parameters: Mapping[str, float | str]
    ) -> models.Model:
        """The model of a step with some values of an effect set by hand."""
        model = models.of_text(step.text, "model")
        term = self.of_kind(self.term(model, place), kind)
        model.terms[place] = models.checked_term(
            {"kind": term.kind, **term.parameters, **parameters}, term.kind
        )
        models.check_lines(model.terms, model.rate_hz, term.kind)
        return model

    def joined(
        self,
        step: Step,
        candidates: Sequence[Candidate],
        between: Callable[[], None] = lambda: None,
    ) -> Outcome:
        text = self.fitted_step(step).text
        key = (text, *((one.kind, str(one.part.key)) for one in candidates))
        return self.session.open_dataset.remembered(
            key,
            lambda: self.session.open_dataset.with_candidates(
                text, candidates, self.session.progress, between
            ),
        )

    def add(
        self, place: Place, kind: Text, state: Text, also: Place | None = None, also_kind: Text = ""
    ) -> Json:
        """A candidate joins the model, or two do at once."""
        step = self.current(state)
        return self.join(step, self.wanted(step, place, kind, also, also_kind))

    def line(self, f_hz: Number, state: Text, wide: bool = False) -> Json:
        """A line where somebody saw a peak; the fit moves a sharp one by less than one over the
        record's length."""
        step = self.current(state)
        text = self.fitted_step(step).text
        return self.join(step, [self.session.open_dataset.line_at(text, f_hz, wide)])

    def join(self, step: Step, candidates: Sequence[Candidate]) -> Json:
        found = self.joined(step, candidates)
        self.session.open_steps.go(step.number)
        title = words.listed((words.title(one.kind, one.part.shape) for one in candidates), str)
        title = "".join(one for one in title if one not in schema.MARKUP)
        return self.grow(f"added {title}", found, off=step.off)

    def set(self, place: Place, kind: Text, parameters: Values, state: Text) -> Json:
        """Values of an effect by hand; they are judged as they stand."""
        step = self.current(state)
        model = self.moved(step, place, kind, parameters)
        return self.grow(
            f"set {words.name(model.kinds[place])}",
            self.session.open_dataset.as_set(self.best(step), model),
            fitted=False,
            off=step.off,
        )

    def fitted_step(self, step: Step) -> Step:
        return fit_of(step, self.session.open_steps.steps)

    def best(self, step: Step) -> Outcome:
        """The fit that a step came from; of a model as given, the fit of its effects."""
        text = self.fitted_step(step).text
        return self.session.open_dataset.outcome_of(text, True, self.session.progress)

    def term(self, model: models.Model, place: int) -> models.Term:
        if place >= len(model.terms):
            raise BadInput(f"there is no effect {place}")
        return model.terms[place]

    def refit(self, state: Text, held: tuple[Place, ...] = ()) -> Json:
        """All values at their best, from where they stand; those of the effects at the places
        `held` stay."""
        step = self.current(state)
        if held:
            model = models.of_text(step.text, "model")
            places = sorted({place for place in held if self.term(model, place)})
            outcome = self.session.open_dataset.around(self.best(step), model, places)
            names = ", ".join(words.name(model.kinds[place]) for place in places)
            return self.grow(f"fitted around {names}", outcome, fitted=False, off=step.off)
        return self.grow("fitted", self.fit(models.of_text(step.text, "model")), off=step.off)

    def remove(self, place: Place, kind: Text, state: Text) -> Json:
        """Switches an effect off: it stays visible and can be switched on again."""
        step = self.current(state)
        model = models.of_text(step.text, "model")
        term = self.of_kind(self.term(model, place), kind)
        if len(model.terms) == 1:
            raise BadInput("a model needs an effect: the last one stays")
        del model.terms[place]
        return self.grow(
            f"without {words.name(term.kind)}",
            self.fit(model),
            off=[*step.off, {"kind": term.kind, **term.parameters}],
        )

    def restore(self, place: Place, kind: Text, state: Text) -> Json:
        """Switches an effect on again."""
        step = self.current(state)
        if place >= len(step.off):
            raise BadInput(f"no effect {place} is switched off")
        model = models.of_text(step.text, "model")
        term = self.of_kind(
            models.checked_term(step.off[place], "an effect that was switched off"), kind
        )
        model.terms.append(term)
        off = [one for index, one in enumerate(step.off) if index != place]
        return self.grow(f"with {words.name(term.kind)} again", self.fit(model), off=off)

    def go(self, number: Place, state: Text) -> Json:
        """To another step of the tree: undo, redo, a branch."""
        self.current(state)
        self.session.open_steps.go(self.known(number))
        return self.session.changed()
