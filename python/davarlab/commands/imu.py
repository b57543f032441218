"""imu: the numbers that a filter wants, of every axis of a log, in one table and one file."""

import argparse
import json
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from .. import axes, files
from .. import model as models
from ..data import floors
from ..data.recording import Recording
from ..diagnosis import fitting, improve, search
from ..errors import BadInput, Moving
from ..inference.reading import Reading
from ..logs import formats
from ..report import noise, parameters, values, verdict, words
from ..report.noise import Axis, Value
from ..thresholds import CHANCE, READING
from . import option_types
from .shared import LOG, REC, Command, argument, emit, log_options, progress, recorded

DATA = "json"  # of --to: what --json prints
LOUD = 10.0  # deg/sqrt(h), of no MEMS gyro at rest: four times that of a noisy one
WHITE = "coefficient_deg_per_sqrt_h"  # of angle random walk, the first effect of a model


def of_axis(whole: Recording, column: str, bandwidth: str | None) -> Axis:
    """What the analysis finds on an axis at rest; of a flight, its floor."""
    recording, model = axes.for_analysis(whole, models.first(whole.rate_hz, column))
    try:
        start = fitting.start(recording, model)
    except Moving as why:
        if whole.doubts and not whole.as_recorded:
            return Axis(column, said=f"no value: {next(iter(whole.doubts.values()))}")
        floor = floors.measured(whole, column, bandwidth) if column.startswith("gyro") else None
        moves = str(why).removeprefix(f"{whole.name}: ").partition(". ")[0]
        return Axis(column, said=f"no value at rest: {moves}", floor=floor)
    except BadInput as why:  # an axis of its own: it is dead, or too little of it is left
        return Axis(column, said=str(why))
    found = search.of_noise(start, model, lambda text: None)
    made, estimates = improve.fitted_model(found, model)
    judgement = found.judgement
    said = words.in_ascii(verdict.adequacy(judgement))
    if judgement.spoiled_by:
        return Axis(column, said=said)
    read = at_95(judgement.reading) if judgement.reading else None
    white = estimates[0][WHITE].number
    level = white if judgement.adequate or read is None else max(white, read[0])
    if column.startswith("gyro") and level > LOUD:
        moves = f"an angle random walk of {level:.3g} deg/sqrt(h) comes from motion or vibration"
        floor = floors.measured(whole, column, bandwidth)
        return Axis(column, said=f"no value at rest: {moves}", floor=floor)
    fits = judgement.adequate and bool(white)
    if not fits and (read is None or not read[0]):
        return Axis(column, said=f"this recording shows no white noise. {said}")
    moved = next((one.share for one in found.seen if one.kind == "motion"), 0.0)
    return Axis(column, made, estimates, fits, said, read, moved=moved)


def at_95(reading: Reading) -> Value:
    """The mean of the two readings, and the ends of their 95 % intervals together."""
    both = (reading.deviation, reading.density)
    share = CHANCE.normal_95 / READING.errors
    low = min(value - share * (value - below) for value, below, _ in both)
    high = max(value + share * (above - value) for value, _, above in both)
    return (both[0][0] + both[1][0]) / 2, low, high


def output_of(options: argparse.Namespace) -> str | None:
    """The file to write: --output, or one named after the log and the format, which is not there
    yet."""
    if not options.to or options.output:
        return str(options.output) if options.output else None
    name = Path(Path(options.recording).name.removesuffix(".gz")).stem
    ending = parameters.FORMATS[options.to].ending if options.to != DATA else ".json"
    path = f"{name}_{options.to}{ending}"
    if os.path.exists(path):
        raise BadInput(f"{path}: exists already. Type -o FILE")
    return path


def run_imu(options: argparse.Namespace) -> int:
    if options.output and not options.to:
        raise BadInput("-o: type --to FORMAT too (such as --to kalibr)")
    several = formats.gyros(options.recording, log_options(options))
    if len(several) == 1 or options.to or options.json:  # a file is of one sensor
        return run_sensor(options)
    return max([run_named(options, str(name)) for name in several])


def run_named(options: argparse.Namespace, sensor: str) -> int:
    """Prints the table of one of several gyros, or why it has none."""
    print(f"--sensor {sensor}")
    try:
        status = run_sensor(argparse.Namespace(**{**vars(options), "sensor": sensor}))
    except BadInput as why:
        status = 1
        print(why)
    print()
    return status


def run_sensor(options: argparse.Namespace) -> int:
    output = output_of(options)
    recording = recorded(options, options.recording)
    names = [name for name in axes.of_page(recording) if name.startswith(("gyro_", "accel_"))]
    if not names:
        raise BadInput(
            f"{options.recording}: no gyro and no accelerometer (there are: "
            f"{', '.join(recording.columns)})"
        )
    progress(f"analysing {', '.join(names)}")
    with ProcessPoolExecutor(min(len(names), os.cpu_count() or 1)) as pool:
        asked = [pool.submit(of_axis, recording, column, options.bandwidth) for column in names]
        found = [one.result() for one in asked]
    target = options.to or noise.DEFAULT
    data = noise.plain(found, recording, target, options.bias_time)
    text = noise.text(found, recording, target, options.bias_time)
    if output:
        write(options, found, output, data)
        text += f"\n\nwrote {output}"
    emit(options, {**data, "file": output}, text)
    return 0 if answered(found, recording) else 1


def answered(found: Sequence[Axis], recording: Recording) -> bool:
    """Has every axis a value that holds: at rest by a model that fits, in motion every gyro by its
    floor."""
    flies = any(one.flies for one in found)
    wanted = [one for one in found if not (flies and one.quantity == "accel")]
    return all(one.fits or one.flies for one in wanted) and not noise.counts(recording)


def write(options: argparse.Namespace, found: Sequence[Axis], output: str, data: Any) -> None:
    if options.to == DATA:
        text = json.dumps(values.plain(data), indent=2) + "\n"
    else:
        given = [(one.column, noise.at_end(one, "value")) for one in found if one.model is not None]
        if not given:
            raise BadInput(
                f"--to {options.to}: {options.recording} moves, so no axis has a value at rest. "
                "Without --to, imu prints the noise in flight"
            )
        remarks = [f"{one.column}: {one.said}" for one in found if not one.fits]
        text = parameters.text(options.to, given, options.inflate, options.bias_time, remarks)
    files.write_whole(output, text.encode())


COMMANDS: dict[str, Command] = {
    "imu": (
        run_imu,
        "measures the noise parameters of every gyro and accelerometer of a log: noise density, "
        "random walk and bias instability",
        [
            REC,
            argument(
                "--to",
                choices=(*parameters.FORMATS, DATA),
                help="units of this program, and a file for it; json: what --json prints",
            ),
            argument("-o", "--output", help="the file (default: named after the log)"),
            argument(
                "--bandwidth",
                metavar="FILTER",
                help="of a recording in motion: what the gyro's noise passed, as davar-sim takes "
                "it; none: nothing (default: none, with a warning)",
            ),
            argument(
                "--inflate",
                type=option_types.positive,
                default=1.0,
                metavar="X",
                help="multiply the noise by X in the file",
            ),
            argument(
                "--bias-time",
                type=option_types.positive,
                default=300.0,
                metavar="SECONDS",
                help="averaging time of the conversion from bias instability to random walk "
                "(default 300)",
            ),
            *LOG,
        ],
    ),
}
