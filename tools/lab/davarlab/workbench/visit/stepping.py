"""The steps of a visit: which one is current, what is beside it, and what leads to another one."""

import hashlib

from ... import model as models
from ...errors import BadInput
from ...report import words
from .. import views


class Superseded(Exception):
    """What was being computed is not wanted now."""


class Stale(BadInput):
    """An action on something that the page showed and that is not so any more."""


class Stepping:
    """Of a visit."""

    def __init__(self, visit):
        self.visit = visit

    def here(self, number=None):
        """The current step; `number`: that step."""
        if not self.visit.desk:
            raise BadInput("no recording is open")
        return (
            self.visit.steps.here if number is None else self.visit.steps.steps[self.known(number)]
        )

    def state(self, step=None):
        """Names what a page shows: the recording, the sight of it, the step and its model."""
        step = step or self.here()
        return hashlib.sha256(
            "\0".join(
                [
                    str(self.visit.steps.path),
                    self.visit.steps.sight.text,
                    str(step.number),
                    step.text,
                ]
            ).encode()
        ).hexdigest()[:16]

    def current(self, state):
        """The current step, if it is the one that the page showed. Raises Stale."""
        step = self.here()
        if state != self.state(step):
            raise Stale(
                "this was shown for another axis, stretch or step; nothing was changed, look at "
                "the page as it is now and try again"
            )
        return step

    def shown(self, number, state):
        """The step that the page showed, where it says so (`state`); else the current one, or that
        of the number."""
        return self.here(number) if state is None else self.current(state)

    def known(self, number):
        if not 0 <= number < len(self.visit.steps.steps):
            raise BadInput(f"there is no step {number}")
        return number

    def outcome(self, step):
        return self.visit.desk.of(step.text, step.fitted, self.visit.progress)

    def grown(self, steps, desk, did, outcome, fitted=True, **more):
        """A new step. Its model file is that of the fitted values, so that a terminal gives the
        same."""
        if fitted:
            desk.keep(outcome)
        judgement = outcome.state.judgement
        steps.grow(
            did, outcome.model, fitted=fitted, error=judgement.error, floor=judgement.floor, **more
        )

    def grow(self, did, outcome, **more):
        self.grown(self.visit.steps, self.visit.desk, did, outcome, **more)
        return self.visit.changed()

    def fit(self, model):
        return self.visit.desk.of(models.text_of(model), True, self.visit.progress)

    def step(self, number=None):
        """A step as the page draws it."""
        step = self.here(number)
        outcome = self.outcome(step)
        return {
            "number": step.number,
            "state": self.state(step),
            "did": step.did,
            "fitted": step.fitted,
            "off": step.off,
            **views.model(outcome, self.visit.desk.recording),
            "text": models.text_of(outcome.model),
        }

    def candidates(self, number=None):
        """The ranking beside a step; given up, and said so, when somebody does something or holds a
        slider."""
        step = self.here(number)
        state = self.state(step)

        def partly(kind, found):
            if self.visit.hurried():
                raise Superseded
            so_far = sorted(filter(None, found), key=lambda candidate: candidate.log_p)
            self.visit.tell(
                ranking=state, trying=words.name(kind), candidates=views.candidates(so_far)
            )

        try:
            return {
                "number": step.number,
                "state": state,
                "candidates": views.candidates(
                    self.visit.desk.ranked(step.text, self.visit.progress, partly)
                ),
            }
        except Superseded:
            return {"number": step.number, "state": state, "superseded": True}

    def candidate(self, step, place, kind):
        ranked = self.visit.desk.ranked(step.text, self.visit.progress)
        if place >= len(ranked):
            raise BadInput(f"there is no candidate {place}")
        return self.of_kind(ranked[place], kind)

    @staticmethod
    def of_kind(found, kind):
        """What stands at a place, if it is of the kind that the page showed there. Raises Stale."""
        if found.kind != kind:
            raise Stale(
                f"{words.name(found.kind)} stands there now, not {words.name(kind)}; nothing was "
                "changed"
            )
        return found

    def ghost(self, place, kind, state):
        """The curve and the error with a candidate, before it is added."""
        step = self.current(state)
        found = self.joined(step, self.candidate(step, place, kind))
        judgement = found.state.judgement
        return {
            "deviation": views.deviation(found, self.visit.desk.recording),
            "error": judgement.error,
            "floor": judgement.floor,
        }

    def preview(self, place, kind, name, value, state):
        """The curve with one value moved, while a slider is held."""
        step = self.current(state)
        model = self.moved(step, place, kind, {name: value})
        return views.preview(self.visit.desk.given(self.best(step), model))

    def moved(self, step, place, kind, parameters):
        """The model of a step with some values of an effect set by hand."""
        model = models.of_text(step.text, "model")
        term = self.of_kind(self.term(model, place), kind)
        model.terms[place] = models.checked_term(
            {"kind": term.kind, **term.parameters, **parameters}, term.kind
        )
        models.check_lines(model.terms, model.rate_hz, term.kind)
        return model

    def joined(self, step, candidate):
        key = (step.text, candidate.kind, str(candidate.part.key))
        return self.visit.desk.remembered(
            key, lambda: self.visit.desk.with_candidate(step.text, candidate, self.visit.progress)
        )

    def add(self, place, kind, state):
        """A candidate joins the model."""
        step = self.current(state)
        return self.join(step, self.candidate(step, place, kind))

    def line(self, f_hz, state, wide=False):
        """A line where somebody saw a peak; the fit moves a sharp one by less than one over the
        record's length."""
        step = self.current(state)
        return self.join(step, self.visit.desk.line_at(step.text, f_hz, wide))

    def join(self, step, candidate):
        found = self.joined(step, candidate)
        self.visit.steps.go(step.number)
        return self.grow(f"added {words.name(candidate.kind)}", found, off=step.off)

    def set(self, place, kind, parameters, state):
        """Values of an effect by hand; they are judged as they stand."""
        step = self.current(state)
        model = self.moved(step, place, kind, parameters)
        return self.grow(
            f"set {words.name(model.kinds[place])}",
            self.visit.desk.as_set(self.best(step), model),
            fitted=False,
            off=step.off,
        )

    def best(self, step):
        """The fit that a step came from; of a model as given, the fit of its effects."""
        while not step.fitted and step.parent is not None:
            step = self.visit.steps.steps[step.parent]
        return self.visit.desk.of(step.text, True, self.visit.progress)

    def term(self, model, place):
        if place >= len(model.terms):
            raise BadInput(f"there is no effect {place}")
        return model.terms[place]

    def refit(self, state, held=()):
        """All values at their best, from where they stand; those of the effects at the places
        `held` stay."""
        step = self.current(state)
        if held:
            model = models.of_text(step.text, "model")
            places = sorted({place for place in held if self.term(model, place)})
            outcome = self.visit.desk.around(self.best(step), model, places)
            names = ", ".join(words.name(model.kinds[place]) for place in places)
            return self.grow(f"fitted around {names}", outcome, fitted=False, off=step.off)
        return self.grow("fitted", self.fit(models.of_text(step.text, "model")), off=step.off)

    def remove(self, place, kind, state):
        """Switches an effect off: it stays in sight and can be switched on again."""
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

    def restore(self, place, kind, state):
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

    def go(self, number, state):
        """To another step of the tree: undo, redo, a branch."""
        self.current(state)
        self.visit.steps.go(self.known(number))
        return self.visit.changed()
