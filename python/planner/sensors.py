"""The gyros of sensors.json: what a part gives at a rate."""

import json
import re
from pathlib import Path
from typing import Any

ROWS: list[dict[str, Any]] = json.loads(
    (Path(__file__).parent / "sensors.json").read_text(encoding="utf-8")
)["rows"]
PARTS: dict[str, dict[str, Any]] = {
    name: part for row in ROWS for name, part in row.get("parts", {}).items()
}


def plain(name: str) -> str:
    """A name without case, "-", "_" and spaces."""
    return re.sub("[-_ ]", "", name.lower())


# Each part also has the name that its maker gives it: ICM-42688-P.
NAMES = {plain(name): key for key, part in PARTS.items() for name in (key, part["title"])}


def bandwidth(part: dict[str, Any], rate_hz: float) -> str | None:
    """The filter at a sample rate, as an option --bandwidth; None: unknown. Raises ValueError."""
    choices = {float(rate): hz for rate, hz in part.get("bandwidth_at_rate", {}).items()}
    if choices:
        if rate_hz not in choices:
            rates = ", ".join(f"{rate:g}" for rate in sorted(choices))
            raise ValueError(f"one of its rates ({rates} Hz)")
        hz = choices[rate_hz]
    elif "bandwidth_share" in part:
        hz = part["bandwidth_share"] * max(rate_hz, part["bandwidth_rate_least"])
    elif "bandwidths" in part:
        fitting = [hz for hz in part["bandwidths"] if hz <= rate_hz / 2]
        hz = max(fitting, default=min(part["bandwidths"]))
    else:
        return part.get("bandwidth")
    percent = f":{part['percent']}" if "percent" in part else ""
    return f"{hz:g}:{part['order']}{percent}"


def look_up(name: str, rate_hz: float) -> dict[str, object]:
    """Fields of Wishes for a part at a rate. Raises ValueError with what was expected."""
    name = NAMES.get(plain(name), "")
    if not name:
        raise ValueError(f"one of {', '.join(sorted(PARTS))}, then @RATE")
    part = PARTS[name]
    if not part["rate_least_hz"] <= rate_hz <= part["rate_most_hz"]:
        raise ValueError(f"a rate of {part['rate_least_hz']:g} to {part['rate_most_hz']:g} Hz")
    filter, noise = bandwidth(part, rate_hz), part.get("noise_dps_per_root_hz")
    return {
        "sensor": f"{name}@{rate_hz:g}",
        "rate_hz": rate_hz,
        "type": "int16",
        "lsb": part["lsb_dps"],
        "bandwidth": filter,
        "sensor_bandwidth": filter,
        "noise": noise and noise * 60 / 2**0.5,
    }
