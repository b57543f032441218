"""The report on a population, as a page and in the terminal."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import jinja2
from davarlab import files
from davarlab.effects import table
from davarlab.report import page as pages
from davarlab.report import words
from davarlab.thresholds import CHANCE
from markupsafe import Markup

from . import limits as limits_of
from . import pictures, population, sources
from .store import Found, Row

HERE = Path(__file__).resolve().parent
ROWS_MAX = 40  # of a table; the Parquet file has all
NAMES_MAX = 8  # coefficients with a picture
WORDS_MAX = 24  # of the command, as it is shown
LEAST_SHOWN = 1e-6  # smaller shares are printed as a bound


@cache
def template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.globals.update(chance=words.chance, rows_max=ROWS_MAX)
    environment.filters.update(
        breakable=pages.breakable,
        number=words.number,
        name=words.name,
        percent=percent,
        coefficient=pictures.coefficient,
    )
    return environment.get_template("page.html")


def percent(share: float | None, digits: int = 2) -> str:
    return (
        "–"
        if share is None
        else "below 0.0001 %"
        if 0 < share < LEAST_SHOWN
        else f"{100 * share:.{digits}g} %"
    )


def command_of(typed: Sequence[str]) -> str:
    """The command as typed, without the middle of a long list of files."""
    return (
        shlex.join(["tools/davarlab", *typed])
        if len(typed) <= WORDS_MAX
        else (
            shlex.join(["tools/davarlab", *typed[:3]])
            + f" .. ({len(typed) - WORDS_MAX} more) .. "
            + shlex.join(typed[3 - WORDS_MAX :])
        )
    )


def where(one: Found, many_axes: bool = False) -> str:
    """The name of a batch in a sentence."""
    batch = f"Batch {one['batch']}" if one["batch"] else "The units"
    return f"{batch}, {one['axis']}" if many_axes else batch


def verdict(found: Found) -> tuple[str, str]:
    """(tone, the main results)."""
    said, many = [], len({one["axis"] for one in found["hidden"]}) > 1
    said += [
        (
            f"{where(one, many)} as a whole {'have' if not one['batch'] else 'has'} an effect that "
            f"the model lacks: {words.name(one['kind'])}."
        )
        for one in found["hidden"]
        if one["named"]
    ]
    judged = found["limits"]
    if judged:
        said.append(
            f"{judged['pass']} of {found['rows']} pass the limits, {judged['fail']} fail"
            + (f", {judged['no result']} have no result." if judged["no result"] else ".")
        )
    if found["failed"]:
        said.append(
            f"{len(found['failed'])} recording{'s' if len(found['failed']) > 1 else ''} "
            "could not be used."
        )
    bad = judged and judged["fail"]
    return (
        "bad"
        if bad or found["failed"]
        else "missing"
        if said and any(one["named"] for one in found["hidden"])
        else "good",
        " ".join(said) or "No significant findings.",
    )


def hidden_sentences(found: Found) -> list[str]:
    """For each batch with a missing effect: the evidence, and other explanations."""
    out, many = [], len({one["axis"] for one in found["hidden"]}) > 1
    for one in (one for one in found["hidden"] if one["named"]):
        alone = found["named_alone"].get(one["batch"], {}).get(one["kind"], 0)
        also = [
            words.name(other["kind"])
            for other in found["hidden"]
            if other["found"]
            and not other["named"]
            and other["kind"] not in one["tied"]
            and (other["axis"], other["batch"]) == (one["axis"], one["batch"])
        ]
        out.append(
            f"{where(one, many)}: {words.name(one['kind'])} raises the log-likelihood by "
            f"{one['mean_gain']:.2f} per unit, compared with "
            f"{one['by_chance']:.2f} in simulated recordings without it. Over {one['units']} "
            f"units, this is {one['deviations']:.1f} standard "
            f"deviations (p {words.chance(one['p_value'])}). "
            f"{alone} of the {one['units']} recordings "
            f"{'shows' if alone == 1 else 'show'} it alone."
            + (
                " These recordings cannot distinguish it from "
                f"{', '.join(map(words.name, one['tied']))}. The reported effect has the fewest "
                "parameters."
                if one["tied"]
                else ""
            )
            + (
                f" Also significant, but weaker: {', '.join(also)}. They may have the same cause."
                if also
                else ""
            )
            + f" To confirm: {table.find(one['kind']).confirm}"
        )
    return out


def attention(rows: Sequence[Row]) -> tuple[list[Row], int]:
    """(rows to show, their total number) of the units to check: those that fail a limit, then
    outliers.
    """
    found = [row for row in rows if row.get("limits") in ("fail", "no result")]
    found += [row for row in rows if row["outlier"] and row not in found]
    return [
        {
            "file": row["file"],
            "batch": row["batch"],
            "axis": row["axis"],
            "limits": row.get("limits", ""),
            "why": row.get("why", []),
            "outlier": row["outlier"],
            "verdict": row["verdict"],
        }
        for row in found[:ROWS_MAX]
    ], len(found)


def contents_of(options: Namespace, rows: Sequence[Row], found: Found) -> dict[str, object]:
    good = [row for row in rows if "failed" not in row]
    names = population.names_of(good)[:NAMES_MAX]
    read = limits_of.read(options.limits).limits if options.limits else ()
    tone, said = verdict(found)
    shown, count = attention(good)
    return {
        "found": found,
        "tone": tone,
        "verdict": said,
        "hidden_said": hidden_sentences(found),
        "attention": shown,
        "attention_count": count,
        "model": files.read_whole(options.model).decode(),
        "command": command_of(options.typed),
        "skip": len(sources.shared_folder([row["file"] for row in rows])),
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "outlier_share": population.OUTLIER,
        "family_wise": CHANCE.family_wise,
        "distributions": pictures.distributions(good, names, read) if names else None,
        "many_axes": len({row["axis"] for row in good}) > 1,
        "gains": pictures.gains(found["hidden"]) if found["hidden"] else None,
        "dates": pictures.over(good, names, "start_s") if names else None,
        "temperatures": pictures.over(good, names, "temperature_degC") if names else None,
    }


def write(contents: dict[str, object], path: Path) -> None:
    style = Markup((Path(pages.__file__).parent / "style.css").read_text(encoding="utf-8"))
    files.write_whole(path, template().render(contents, style=style).encode())


def text(found: Found, folder: Path) -> str:
    """The output in the terminal."""
    out = [words.in_ascii(verdict(found)[1]), ""]
    out += [
        f"{'batch':<14}{'axis':<14}{'coefficient':<52}{'units':>6}{'median':>11}{'spread':>9}{'outliers':>9}"
    ]
    out += [
        f"{one['batch']:<14}{one['axis']:<14}{one['coefficient']:<52}{one['units']:>6}"
        f"{one['median']:>11.4g}{100 * one['spread']:>7.1f} %{len(one['outliers']):>9}"
        for one in found["coefficients"]
    ]
    out += [words.in_ascii(line) for line in hidden_sentences(found)]
    for one in (found["limits"] or {}).get("stated", []):
        out.append(
            f"{one['limit']}: a unit exactly at the limit fails in {100 * one['at_limit']:g} % of "
            f"cases, the median unit in {words.in_ascii(percent(one['median_unit']))}"
            f", and a unit at {one['caught_from']:.4g} in 95 %"
        )
    out += [
        f"{one['coefficient']} changes with {one['against']}: {100 * one['slope']:+.3g} % per "
        f"{'day' if one['against'] == 'date' else 'degree'}"
        for one in found["trends"]
        if one["found"]
    ]
    now = found["done_now"]
    if now["recordings"]:
        out.append(
            f"{now['recordings']} recordings in {now['wall_s']:.0f} s on {now['workers']} "
            f"worker{'s' * (now['workers'] != 1)}: "
            f"{now['recordings'] / max(now['worker_s'], 1e-9):.2g} per second and worker, "
            f"{now['recordings'] / max(now['cpu_s'], 1e-9):.2g} per second "
            f"of processor time, {now['recordings'] / max(now['wall_s'], 1e-9):.2g} per second "
            "in total"
        )
    out.append(f"{folder}/fleet.parquet, {folder}/fleet.html")
    return "\n".join(out)
