"""The gyro's numbers in a kalibr imu.yaml (https://github.com/ethz-asl/kalibr/wiki/yaml-formats), as effects of a model."""

import math
import reprlib

import yaml

from .effects import table
from .errors import BadInput

KINDS = {"gyroscope_noise_density": "angle_random_walk", "gyroscope_random_walk": "rate_random_walk"}  # rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)


def number(value, where):
    """Of a YAML value; 1e-4 without a point is text to YAML 1.1."""
    try:
        found = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not 0 <= found < 1e30:
        raise BadInput(f"{where}: a number expected, found {reprlib.repr(value)}")
    return found


def sizes(text, where):
    """kind -> size in the unit of a model file. Raises BadInput for what is no such file."""
    try:
        data = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as why:
        raise BadInput(f"{where}: not YAML: {str(why).splitlines()[0]}") from None
    if isinstance(data, dict) and isinstance(data.get("imu0"), dict):
        data = data["imu0"]
    found = {}
    for key, kind in KINDS.items():
        value = data.get(key) if isinstance(data, dict) else None
        if value is None:
            continue
        found[kind] = math.degrees(number(value, f"{where}: {key}")) / table.find(kind).size.scale
    if not found:
        raise BadInput(f"{where}: neither {' nor '.join(KINDS)} is in it")
    return found
