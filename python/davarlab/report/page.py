"""The report: one HTML file that needs nothing else. Its charts are drawn by the code of the
workbench, which is packed into it."""

import base64
import hashlib
import json
import re
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from .. import axes, files
from . import verdict, words

HERE = Path(__file__).resolve().parent
WORKBENCH = HERE.parent / "workbench"
IMPORT = re.compile(r'^import (?:\* as (\w+)|(\{[^}]*\})) from "/(page/.*)";$', re.MULTILINE)
EXPORT = re.compile(r"^export ((?:async )?(?:const|function|class)) (\w+)", re.MULTILINE)
STYLES = ("tokens.css", "chart.css")


def own(path: Path) -> str:
    """A file of this package."""
    return path.read_text(encoding="utf-8")


def packed(text: str, done: dict[str, str]) -> str:
    """A module as the body of a function that returns what it exports. Those that it imports are
    added to `done`: path -> the same of them, in an order in which they can run."""
    for _, _, path in IMPORT.findall(text):
        if path not in done:
            done[path] = packed(own(WORKBENCH / path), done)
    names = ", ".join(name for _, name in EXPORT.findall(text))
    body = EXPORT.sub(r"\1 \2", text)

    def taken(found: re.Match[str]) -> str:
        return f'const {found[1] or found[2].replace(" as ", ": ")} = modules["{found[3]}"];'

    return f"(() => {{ {IMPORT.sub(taken, body)} return {{ {names} }}; }})()"


@cache
def script() -> tuple[str, str]:
    """(the code of the charts, its hash for a Content-Security-Policy)."""
    done: dict[str, str] = {}
    last = packed(own(HERE / "drawing.js"), done)
    modules = "".join(f'modules["{path}"] = {text};\n' for path, text in done.items())
    text = f'"use strict";\nconst modules = {{}};\n{modules}{last};\n'
    return text, base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def quantity(
    column: str, key: str, value: float | str | None, show: Callable[[Any], str] = words.number
) -> Markup:
    """A number as people read it, with its full value for machines: <data value="..."> and its name
    in the JSON for the column."""
    if value is None or value != value:
        return Markup("–")
    full = value if isinstance(value, str) else repr(float(value))
    return Markup('<data data-key="{}" value="{}">{}</data>').format(
        axes.key_said(key, column), full, show(value)
    )


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
    environment.globals.update(chance=words.chance, bounds=words.bounds, section=verdict.section)
    environment.filters.update(breakable=breakable, number=words.number, name=words.name)
    return environment.get_template("page.html")


def html(contents: Mapping[str, Any], column: str = "") -> str:
    """The page. column: the names in the JSON are those of its files."""
    code, digest = script()
    styles = [own(WORKBENCH / "page/style" / name) for name in STYLES] + [own(HERE / "style.css")]
    data = json.dumps(contents["drawn"], allow_nan=False).replace("<", "\\u003c")
    return template().render(
        contents,
        quantity=partial(quantity, column),
        style=Markup("\n".join(styles)),
        digest=digest,
        data=Markup(data),
        charts=Markup(code),
    )


def write(contents: Mapping[str, Any], path: str | Path, column: str = "") -> None:
    """Writes the page whole or not at all. Raises BadInput when `path` cannot be written."""
    files.write_whole(path, html(contents, column).encode())
