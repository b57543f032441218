"""The numbers in a kalibr imu.yaml (https://github.com/ethz-asl/kalibr/wiki/yaml-formats) or of a
data sheet, as effects of a model."""

import math
import re
import reprlib
from collections.abc import Iterable, Mapping
from typing import Any

import yaml

from . import files
from .effects import sheets, table
from .errors import BadInput
from .files import StrPath
from .model import Model, Term
from .tables.constants import DEG_PER_RAD

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
EXAMPLES = {
    False: "0.3deg/sqrt(h), 0.005dps/sqrt(Hz) or 10deg/h",
    True: "100ug/sqrt(Hz), 0.05m/s/sqrt(h) or 40ug",
}  # of a gyro, of an accelerometer


def model_of(found: Mapping[str, float], column: str, rate_hz: float | None) -> Model:
    """A Model of kind -> size."""
    return Model(
        rate_hz,
        column,
        [Term(kind, {table.find(kind).size.name: size}) for kind, size in found.items()],
    )


def numbers(words: Iterable[str]) -> list[str]:
    """Of a data sheet, each with its unit, where a shell took 0.66 deg/sqrt(hr) for two words."""
    found: list[str] = []
    for word in words:
        if found and not re.match(r"[-+.\d](?!σ)", word):
            found[-1] += f" {word}"
        else:
            found.append(word)
    return found


def of_sheet(words: Iterable[str], column: str, rate_hz: float | None) -> Model:
    """A Model of the numbers of a data sheet, each with its unit, which says what it is:
    0.005deg/s/sqrt(Hz), 10deg/h."""
    of_accel, found = column.startswith("accel"), {}
    for word in numbers(words):
        match = re.fullmatch(r"([0-9.]+(?:[eE][-+]?\d+)?)\s*(\D.*)", word)
        try:
            if not match:
                raise BadInput("a number with its unit expected")
            accel, kind, factor = sheets.meaning(match[2])
        except BadInput as why:
            raise BadInput(f"{word}: {why}. Examples: {EXAMPLES[of_accel]}") from None
        if accel != of_accel:
            sensor, other = ("accelerometer", "accel_z_g") if accel else ("gyro", "gyro_z_dps")
            raise BadInput(
                f"{word}: a unit of {'an' if accel else 'a'} {sensor}, but the column is {column}. "
                f"Type --column {other}"
            )
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
            * (1 if kinds is ACCEL_KINDS else DEG_PER_RAD)
            / table.find(kind).size.scale
        )
    if not found:
        raise BadInput(f"{where}: neither {' nor '.join(kinds)} is in it")
    return found
