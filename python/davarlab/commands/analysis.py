"""fit, compare, diagnose, improve and plot: a model against a recording."""

import argparse
from collections.abc import Callable

from .. import axes, files
from .. import model as models
from ..data.recording import Recording
from ..diagnosis import compare, evidence, fitting, improve
from ..diagnosis.judge import Judgement
from ..diagnosis.state import Judged, Progress
from ..errors import BadInput, of_extra
from ..report import terminal, values, verdict, words
from .shared import (
    AXES,
    HELD_OUT,
    LOG,
    MODEL,
    MODEL_MAYBE,
    OUT,
    OUT_MAYBE,
    REC,
    REPORT,
    Command,
    emit,
    given_model,
    progress,
    recorded,
)

DETAIL = 3  # candidates that are described in full

One = tuple[axes.Found, str]  # what a command found on an axis, and its text
Run = Callable[[argparse.Namespace], int]


def load(options: argparse.Namespace) -> tuple[Recording, models.Model]:
    """(recording, model) for the analysis. axes.py converts those of an accelerometer. Without -m,
    a first model, which every command but fit takes fitted."""
    given = given_model(options)
    recording, model = axes.for_analysis(recorded(options, options.recording), given)
    models.check_fits(model, recording, options.model)
    if not options.model:
        kinds = ", ".join(models.kind_said(kind, given.column) for kind in model.kinds)
        progress(f"no -m: {kinds} of {given.column} are fitted")
        if options.command != "fit":
            model = improve.fit(recording, model, progress_of(options))[1]
    elif options.command != "fit":
        models.check_noise(model, options.model)
    return recording, model


def load_held_out(options: argparse.Namespace, model: models.Model) -> Recording | None:
    if not options.held_out:
        return None
    held_out, model = axes.for_analysis(recorded(options, options.held_out), given_model(options))
    models.check_fits(model, held_out, options.model)
    return held_out


def column_of(options: argparse.Namespace) -> str:
    return given_model(options).column


def progress_of(options: argparse.Namespace) -> Progress:
    """Progress, each text once."""
    last = ""

    def told(text: str) -> None:
        nonlocal last
        if text != last:
            progress(text)
        last = text

    return told


def output_of(options: argparse.Namespace) -> str | None:
    """The output file for the model of this axis."""
    return options.output and (
        str(axes.file_of(options.output, options.axis))
        if getattr(options, "axis", None)
        else options.output
    )


def write(model: models.Model, path: str, said: list[str]) -> None:
    """Writes a model with its verdict in comments."""
    models.write(model, path, "\n".join(map(words.in_ascii, said)))


def each_axis(one: Callable[[argparse.Namespace], One]) -> Run:
    """A command on the axis of the model, or on all axes of --axes. one(options) -> axes.Found and
    the text of one axis."""

    def run(options: argparse.Namespace) -> int:
        if not options.axes:
            found, text = one(options)
            emit(options, axes.said(found.data, found.column), text)
            return found.status
        if getattr(options, "report", None):
            raise BadInput("--report works for one axis only: remove --axes")
        columns = axes.columns_of(recorded(options, options.recording), options.axes)
        if options.__dict__.get("output"):
            files.check_outputs(
                [axes.file_of(options.output, column) for column in columns], [options.recording]
            )
        per_axis: list[axes.Found] = []
        for options.axis in columns:
            progress(f"axis {options.axis}")
            per_axis.append(one(options)[0])
        emit(
            options,
            {"axes": {one.column: axes.said(one.data, one.column) for one in per_axis}},
            axes.text(per_axis),
        )
        return max(one.status for one in per_axis)

    return run


def fit_one(options: argparse.Namespace) -> One:
    recording, model = load(options)
    state, fitted, entries = improve.fit(recording, model, progress_of(options))
    column, output = column_of(options), output_of(options)
    if output:
        said = [verdict.adequacy(state.judgement), *verdict.to_find(state.judgement)]
        write(axes.called(fitted, column), output, said)
    data = {
        "effects": values.fitted(fitted, entries, state.judgement.adequate),
        "model": output,
        **values.judgement(state.judgement),
        "observations": values.observations(state.seen),
        "intervals_hold": state.judgement.adequate,
    }
    default = device_default(recording, fitted, state.judgement)
    data["device_default"] = default or None
    return axes.Found(column, 0, data, fitted, entries), terminal.fit(
        fitted, entries, state.judgement, state.seen, default
    )


def device_default(recording: Recording, fitted: models.Model, judgement: Judgement) -> str:
    """The sentence of declared.default_said. A model that does not fit has no ARW to compare."""
    from ..report import declared

    if not judgement.adequate or fitted.column not in recording.gyros:
        return ""
    return declared.default_said(fitted, declared.count_of(recording, fitted.column))


def report(
    options: argparse.Namespace,
    recording: Recording,
    model: models.Model,
    found: tuple[compare.Comparison, Judged] | improve.Improvement,
) -> None:
    """Writes the page of --report for a comparison, given with the refitted model, or for an
    improvement."""
    if not options.report:
        return
    from ..report import contents, page  # they take half a second to load

    progress("drawing the report")
    named = {
        "recording": options.recording,
        "model": options.model,
        "held-out recording": getattr(options, "held_out", None),
    }
    run = contents.Run(
        options.typed,
        recording,
        model,
        {role: path for role, path in named.items() if path},
        [word for path in options.effects for word in ("--effects", path)]
        + (["--rate", f"{options.rate:g}"] if options.rate else []),
        getattr(options, "output", None),
    )
    page.write(
        contents.of_comparison(run, *found)
        if isinstance(found, tuple)
        else contents.of_improvement(run, found),
        options.report,
        column_of(options),
    )


def compare_one(options: argparse.Namespace) -> One:
    recording, model = load(options)
    state = fitting.judged(fitting.start(recording, model, progress_of(options)))
    found = compare.compare(recording, model, progress_of(options), state)
    report(options, recording, model, (found, state))
    return (
        axes.Found(
            column_of(options),
            0 if found.adequate else 1,
            values.comparison(found),
            model,
            improve.as_it_is(model),
        ),
        "\n".join(
            [
                terminal.comparison(found, model.column, evidence.notes(recording, model)),
                *verdict.to_find(found.judgement, state.judgement),
            ]
        ),
    )


def diagnose_one(options: argparse.Namespace) -> One:
    recording, model = load(options)
    held_out = load_held_out(options, model)
    found = improve.improve(recording, model, held_out, progress_of(options), DETAIL)
    report(options, recording, model, found)
    return axes.Found(
        column_of(options), 0, values.diagnosis(found), found.model, found.estimates
    ), terminal.diagnosis(found)


def improve_one(options: argparse.Namespace) -> One:
    recording, model = load(options)
    held_out = load_held_out(options, model)
    found = improve.improve(
        recording, model, held_out, progress_of(options), DETAIL if options.report else 0
    )
    column, output = column_of(options), output_of(options)
    if output:
        said = [verdict.of_final_model(found)]
        said += verdict.next_steps(found.unexplained) if found.unexplained else []
        write(axes.called(found.model, column), output, said)
    report(options, recording, model, found)
    default = device_default(recording, found.model, found.judgement)
    return (
        axes.Found(
            column,
            0 if found.judgement.adequate else 1,
            {**values.improvement(found, output), "device_default": default or None},
            found.model,
            found.estimates,
        ),
        terminal.improvement(found) + f"\n{default}" * bool(default),
    )


def run_plot(options: argparse.Namespace) -> int:
    files.check_ending(options.output, (".png", ".pdf", ".svg"))
    with of_extra("plots"):
        from ..report import plot

    recording, model = load(options)
    found = compare.compare(recording, model, progress_of(options))
    plot.draw(found, options.output)
    emit(options, {"picture": options.output}, options.output)
    return 0


# command: (function, what it does, arguments)
COMMANDS: dict[str, Command] = {
    "fit": (
        each_axis(fit_one),
        "fits the parameters, with 95 %% intervals; without -m, of a first model",
        [REC, MODEL_MAYBE, OUT_MAYBE, AXES, *LOG],
    ),
    "compare": (
        each_axis(compare_one),
        "compares model and measurement: where the model fails, and by how much",
        [REC, MODEL, REPORT, AXES, *LOG],
    ),
    "diagnose": (
        each_axis(diagnose_one),
        "finds the missing physical effect; without -m, of a fitted first model",
        [REC, MODEL_MAYBE, HELD_OUT, REPORT, AXES, *LOG],
    ),
    "improve": (
        each_axis(improve_one),
        "adds missing effects until the model is adequate; without -m, to a fitted first model",
        [REC, MODEL_MAYBE, HELD_OUT, OUT_MAYBE, REPORT, AXES, *LOG],
    ),
    "plot": (
        run_plot,
        "plots Allan deviation, failure map and residual spectrum (.png, .pdf or .svg)",
        [REC, MODEL, OUT, *LOG],
    ),
}
