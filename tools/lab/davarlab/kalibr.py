"""The numbers in a kalibr imu.yaml (https://github.com/ethz-asl/kalibr/wiki/yaml-formats) or of a
data sheet, as effects of a model."""

import math
import re
import reprlib
from collections.abc import Iterable, Mapping
from typing import Any

import yaml

from . import files
from .effects import table
from .errors import BadInput
from .files import StrPath
from .model import Model, Term

KINDS = {
    "gyroscope_noise_density": "angle_random_walk",
    "gyroscope_random_walk": "rate_random_walk",
}  # rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)


class Texts(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML ships no types
    """YAML whose values are texts as they stand: YAML 1.1 takes 1:30 for ninety, and 1e-4 for a
    text."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, Any]]] = {}


for _tag in ("int", "float", "bool"):
    Texts.add_constructor(f"tag:yaml.org,2002:{_tag}", yaml.SafeLoader.construct_yaml_str)
NOTHING = ("", "~", "null", "Null", "NULL")  # what YAML calls so


def number(value: Any, where: StrPath) -> float:
    """Of a text, as it stands in the file."""
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = math.nan
    if not 0 <= found < 1e30:
        raise BadInput(f"{where}: a number expected, found {reprlib.repr(value)}")
    return found


ACCEL_KINDS = {
    "accelerometer_noise_density": "angle_random_walk",
    "accelerometer_random_walk": "rate_random_walk",
}  # m/s^2/sqrt(Hz), m/s^3/sqrt(Hz)
RAD = 180 / math.pi
# unit of a data sheet: (kind, factor to deg and s; of an accelerometer to m and s)
SHEET = {
    "deg/sqrt(h)": ("angle_random_walk", 1 / 60),
    "deg/s/sqrt(Hz)": ("angle_random_walk", 1.0),
    "mdeg/s/sqrt(Hz)": ("angle_random_walk", 1e-3),
    "rad/s/sqrt(Hz)": ("angle_random_walk", RAD),
    "rad/sqrt(s)": ("angle_random_walk", RAD),
    "deg/h/sqrt(Hz)": ("angle_random_walk", 1 / 3600),
    "deg/h": ("bias_instability", 1 / 3600),
    "deg/s": ("bias_instability", 1.0),
    "rad/s": ("bias_instability", RAD),
    "deg/h/sqrt(h)": ("rate_random_walk", 1 / 216000),
    "rad/s^2/sqrt(Hz)": ("rate_random_walk", RAD),
    "deg/s^2/sqrt(Hz)": ("rate_random_walk", 1.0),
}
G = 9.80665
ACCEL_SHEET = {
    "m/s/sqrt(h)": ("angle_random_walk", 1 / 60),
    "m/s^2/sqrt(Hz)": ("angle_random_walk", 1.0),
    "ug/sqrt(Hz)": ("angle_random_walk", G * 1e-6),
    "mg/sqrt(Hz)": ("angle_random_walk", G * 1e-3),
    "g/sqrt(Hz)": ("angle_random_walk", G),
    "ug": ("bias_instability", G * 1e-6),
    "mg": ("bias_instability", G * 1e-3),
    "m/s^2": ("bias_instability", 1.0),
    "m/s^3/sqrt(Hz)": ("rate_random_walk", 1.0),
}


def model_of(found: Mapping[str, float], column: str, rate_hz: float | None) -> Model:
    """A Model of kind -> size."""
    return Model(
        rate_hz,
        column,
        [Term(kind, {table.find(kind).size.name: size}) for kind, size in found.items()],
    )


def of_sheet(words: Iterable[str], column: str, rate_hz: float | None) -> Model:
    """A Model of the numbers of a data sheet, each with its unit, which says what it is:
    0.005deg/s/sqrt(Hz), 10deg/h."""
    units, found = ACCEL_SHEET if column.startswith("accel") else SHEET, {}
    for word in words:
        match = re.fullmatch(r"([0-9.]+(?:[eE][-+]?\d+)?)\s*(\D.*)", word)
        if not match or match[2] not in units:
            raise BadInput(f"{word}: a number with its unit expected, one of {', '.join(units)}")
        kind, factor = units[match[2]]
        if kind in found:
            raise BadInput(f"{word}: a second number for {kind}")
        found[kind] = number(match[1], word) * factor / table.find(kind).size.scale
    return model_of(found, column, rate_hz)


def of_file(path: StrPath, column: str, rate_hz: float | None = None) -> Model:
    """A Model of a kalibr file: of its gyro, or of its accelerometer where the column is one.
    Raises BadInput."""
    try:
        text = files.read_whole(path).decode("utf-8")
    except UnicodeDecodeError as why:
        raise BadInput(f"{path}: {why}") from None
    return model_of(
        sizes(text, path, ACCEL_KINDS if column.startswith("accel") else KINDS), column, rate_hz
    )


def sizes(text: str, where: StrPath, kinds: Mapping[str, str] = KINDS) -> dict[str, float]:
    """kind -> size in the unit of a model file. Raises BadInput for what is no such file."""
    try:
        data = yaml.load(text, Texts)
    except (yaml.YAMLError, ValueError, RecursionError) as why:
        raise BadInput(f"{where}: not YAML: {str(why).splitlines()[0]}") from None
    if isinstance(data, dict) and isinstance(data.get("imu0"), dict):
        data = data["imu0"]
    found = {}
    for key, kind in kinds.items():
        value = data.get(key) if isinstance(data, dict) else None
        if value in (None, *NOTHING):
            continue
        found[kind] = (
            number(value, f"{where}: {key}")
            * (1 if kinds is ACCEL_KINDS else RAD)
            / table.find(kind).size.scale
        )
    if not found:
        raise BadInput(f"{where}: neither {' nor '.join(kinds)} is in it")
    return found
