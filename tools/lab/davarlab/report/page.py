"""The page: one HTML file that needs nothing else."""

import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from .. import axes, files
from . import words

PICTURE = re.compile(r'("data:[^"]*")')
HERE = Path(__file__).resolve().parent


def quantity(
    key: str, value: float | str | None, show: Callable[[Any], str] = words.number
) -> Markup:
    """A number as people read it, with its full value for machines: <data value="..."> and its name
    in the JSON."""
    if value is None or value != value:
        return Markup("–")
    full = value if isinstance(value, str) else repr(float(value))
    return Markup('<data data-key="{}" value="{}">{}</data>').format(key, full, show(value))


def breakable(name: object) -> Markup:
    """A long name with underscores may break after each."""
    return Markup("_<wbr>").join(escape(part) for part in str(name).split("_"))


@cache
def template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.globals.update(quantity=quantity, chance=words.chance, bounds=words.bounds)
    environment.filters.update(breakable=breakable, number=words.number, name=words.name)
    return environment.get_template("page.html")


def html(contents: Mapping[str, Any], column: str = "") -> str:
    """The page, in the language of the column: that of a gyro, an accelerometer, or a clock."""
    text = template().render(
        contents, style=Markup((HERE / "style.css").read_text(encoding="utf-8"))
    )
    pieces = PICTURE.split(text)  # pictures are at the odd places
    return "".join(
        piece if place % 2 else axes.in_units(piece, column) for place, piece in enumerate(pieces)
    )


def write(contents: Mapping[str, Any], path: str | Path, column: str = "") -> None:
    """Writes the page whole or not at all. Raises BadInput when `path` cannot be written."""
    files.write_whole(path, html(contents, column).encode())
