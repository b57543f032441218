"""The output of the commands: the sentences of words.py, and tables."""

from collections.abc import Iterable, Sequence

from ..candidates.candidate import Candidate
from ..data.observations import Observation
from ..diagnosis.compare import Comparison
from ..diagnosis.improve import Estimates, Improvement, Step
from ..diagnosis.judge import Judgement
from ..effects import table
from ..inference.estimate import Estimate, as_shown
from ..model import Model, kind_said, name_said, unit_said
from . import verdict as verdicts
from . import words

WHERE_MAX, CANDIDATES_MAX = 8, 5


def p_text(p: float, sign: str = "= ") -> str:
    return f"<{' ' if sign else ''}{words.TINY:g}" if p < words.TINY else f"{sign}{p:.3g}"


def interval(estimate: Estimate) -> str:
    """Both ends, with enough digits to distinguish them."""
    if estimate.undetermined:
        return "undetermined"
    if estimate.low is None:
        return ""
    low, high = next(
        (
            (a, b)
            for digits in range(5, 10)
            for a, b in [(f"{estimate.low:.{digits}g}", f"{estimate.high:.{digits}g}")]
            if a != b or digits == 9
        )
    )
    return f"95 %: {low} .. {high}"


def estimates(model: Model, entries: Sequence[Estimates]) -> str:
    lines = []
    for term, entry in zip(model.terms, entries):
        lines.append(kind_said(term.kind, model.column))
        for p in table.find(term.kind).parameters:
            if p.name not in entry:
                continue
            name, e = name_said(p.name, model.column), entry[p.name]
            unit = unit_said(p.unit, model.column)
            if not isinstance(e.value, str):
                lines.append(f"  {name:<36}{e.value:>12.5g}   {interval(e)} {unit}".rstrip())
            else:
                lines.append(f"  {name:<36}{words.course(str(e.value)):>12}")
    return "\n".join(lines)


def observed(seen: Sequence[Observation]) -> list[str]:
    return [words.in_ascii(verdicts.observation(one)) for one in seen]


def fit(
    model: Model,
    entries: Sequence[Estimates],
    judgement: Judgement,
    seen: Sequence[Observation],
    default: str = "",
) -> str:
    """The output of `fit`: the verdict, then the parameters. default: of declared.default_said."""
    lines = [words.in_ascii(verdicts.adequacy(judgement)), *verdicts.to_find(judgement)]
    lines += observed(seen)
    if not judgement.adequate and not judgement.spoiled_by:
        lines.append(verdicts.NOT_VALID)
    lines += [default] * bool(default)
    lines += verdicts.superfluous(model.kinds, as_shown(entries, judgement.adequate))
    return "\n".join(lines) + "\n\n" + estimates(model, as_shown(entries, judgement.adequate))


def comparison(
    c: Comparison, column: str, notes: Iterable[str] = (), against: Sequence[Candidate] = ()
) -> str:
    """notes: of the recording. against: of a search beside this model."""
    lines = [
        f"model: {', '.join(kind_said(kind, column) for kind in c.effects)}",
        f"error {c.error:.4f} (floor {c.error_floor:.4f}), p {p_text(c.p_value)}",
        words.in_ascii(verdicts.contested(c.judgement, against)),
        words.in_ascii(verdicts.misfit(c)),
        *observed(c.observations),
        *notes,
    ]
    lines += [
        f"  {verdicts.section(w.start_s, w.stop_s):>16} s, tau {w.tau_s:g} s: measured "
        f"{w.measured_dps:.3g}, model {w.model_dps:.3g} {c.unit}, ratio {w.ratio:.2f} ({w.z:+.1f} "
        "sigma)"
        for w in c.where[:WHERE_MAX]
    ]
    lines += [
        f"  residual correlates with {name}: {r:+.3f}"
        for name, (r, p) in c.correlations.items()
        if p < 1e-3
    ]
    return "\n".join(lines)


def verdict(found: Improvement) -> str:
    """The verdict, its numbers, the failed checks, what was excluded, and what to do next."""
    lines = [verdicts.of_improvement(found)[1], verdicts.improvement(found)]
    failed = verdicts.failed_tests(found.comparisons[-1].tests)
    if found.unexplained and failed:
        lines.append(f"The failed checks detect: {failed}.")
    if found.unexplained:
        lines += verdicts.excluded(found.unexplained)
        lines += [f"Next: {step}" for step in verdicts.next_steps(found.unexplained)]
    elif found.diagnosis.useless:
        lines.append(
            "Significant, but without a better fit to the Allan deviation: "
            f"{words.listed(part.kind for part in found.diagnosis.useless)}."
        )
    return words.in_ascii("\n".join(lines + verdicts.confirmations(found)))


def candidates(found: Improvement) -> str:
    """The added effects with their fitted values, then each candidate alone with the initial
    effects."""
    added, lines, column = found.added, [], found.model.column
    if added:
        lines = ["Added effects, in this order, all fitted together:"]
        lines += [
            f"  {kind_said(kind, column)}: {words.strength(kind, sizes, column)}"
            for kind, sizes in zip(
                added, as_shown(found.estimates[-len(added) :], found.judgement.adequate)
            )
        ] + [""]
    lines.append(
        "Each candidate alone with the initial effects"
        + (" (a significant one may only imitate an added effect):" if added else ":")
    )
    first = [c for c in found.candidates if c.kind in added]
    rest = [c for c in found.candidates if c.kind not in added][
        : max(CANDIDATES_MAX - len(first), 3)
    ]
    lines += [
        f"{rank}. {kind_said(c.kind, column)}{' (added)' if c.kind in added else ''}: {c.why}"
        for rank, c in enumerate(first + rest, 1)
    ]
    return words.in_ascii("\n".join(lines))


def step(name: str, s: Step) -> str:
    outside = f"{s.error_held_out:.4f}" if s.error_held_out is not None else "-"
    return f"{name:<28}{s.error:>9.4f}{s.error_floor:>9.4f}{outside:>10}{p_text(s.p_value, ''):>11}"


def steps(found: Improvement) -> str:
    lines = [
        f"{'added':<28}{'error':>9}{'floor':>9}{'held out':>10}{'p':>11}",
        step("(initial model)", found.steps[0]),
    ]
    lines += [step("(refitted)", found.refitted)] if found.refitted else []
    column = found.model.column
    added = [step(kind_said(str(s.added), column), s) for s in found.steps[1:]]
    return "\n".join(lines + added)


def diagnosis(found: Improvement) -> str:
    return "\n\n".join(
        [
            comparison(
                found.comparison, found.model.column, found.notes, verdicts.against_given(found)
            ),
            verdict(found),
            candidates(found),
        ]
    )


def improvement(found: Improvement) -> str:
    top = "\n".join([steps(found), *observed(found.comparison.observations), *found.notes])
    shown = as_shown(found.estimates, found.judgement.adequate)
    hint = [] if found.judgement.adequate else [verdicts.NOT_VALID]
    hint += verdicts.superfluous(found.model.kinds, shown)
    return "\n\n".join([top, verdict(found), *hint, estimates(found.model, shown)])
