"""davarlab fleet: what is missing is done, then table and page are written of all."""

import contextlib
import importlib.metadata
import json
import re
import signal
import time
import zlib
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from typing import TypedDict

from davarlab import files
from davarlab import model as models
from davarlab.commands.shared import log_options
from davarlab.diagnosis.state import Progress
from davarlab.errors import BadInput
from davarlab.model import Model
from davarlab.report import contents, values
from davarlab.thresholds import CHANCE

from . import cluster, limits, population, sources, store
from . import job as jobs
from .store import Found, Row

TOLD_S = 2.0  # between two lines of progress
STOPPED = 130  # exit status behind Ctrl-C, as of a shell
Todo = tuple[jobs.Job, str | None]  # with its marker
Emit = Callable[[Namespace, object, str], None]


class Counted(TypedDict):
    """What was done now. worker_s: seconds of all workers; cpu_s: of their processors."""

    recordings: int
    failed: int
    samples: int
    wall_s: float
    worker_s: float
    cpu_s: float
    workers: int


def batch_of(pattern: re.Pattern[str] | None, address: str) -> str:
    """The batch that an address tells: the first group of the pattern, or all that it matches; ""
    where it does not match.
    """
    found = pattern.search(address) if pattern else None
    return (found.group(1 if found.re.groups else 0) or "") if found else ""


def pattern_of(text: str | None) -> re.Pattern[str] | None:
    try:
        return re.compile(text) if text else None
    except re.error as why:
        raise BadInput(f"--batch {text}: not a regular expression ({why})") from None


def chosen(addresses: Sequence[str], count: int) -> set[str]:
    """Those of which a recording is drawn by chance: as many as are wanted, by a number of their
    names, so that more files change little. Of the names only what is behind the folder that all
    share counts: the same files are chosen wherever they lie.
    """
    shared = len(sources.shared_folder(addresses))
    return set(
        sorted(
            addresses,
            key=lambda name: (zlib.crc32(name[shared:].encode("utf-8", "surrogateescape")), name),
        )[:count]
    )


def work_of(options: Namespace, addresses: Sequence[str], model: Model) -> list[jobs.Job]:
    how = log_options(options)
    by_chance = chosen(addresses, options.chance)
    return [
        jobs.Job(
            address,
            models.text_of(model),
            options.axes,
            how,
            tuple(options.effects),
            address in by_chance,
        )
        for address in addresses
    ]


def undone(
    work: Sequence[jobs.Job], kept: store.Store, version: str, progress: Progress
) -> list[Todo]:
    """(job, marker) of what is missing or has changed."""
    found = []
    for job in work:
        marker = jobs.marker(sources.identity(job.address), job, version)
        if not store.done(kept.kept(job.address), marker, job.chance):
            found.append((job, marker))
    progress(f"{len(work)} recordings: {len(work) - len(found)} finished, {len(found)} remaining")
    return found


def advance(
    options: Namespace, todo: Sequence[Todo], kept: store.Store, version: str, progress: Progress
) -> Counted:
    """Does the jobs, each kept as it comes."""
    markers, begin, told = (
        {job.address: marker for job, marker in todo},
        time.monotonic(),
        time.monotonic(),
    )
    count: Counted = {
        "recordings": 0,
        "failed": 0,
        "samples": 0,
        "wall_s": 0.0,
        "worker_s": 0.0,
        "cpu_s": 0.0,
        "workers": 0,
    }
    if not todo:
        return count
    with cluster.client(options.scheduler, min(options.workers, len(todo))) as client:
        if options.scheduler:
            cluster.check_versions(client, version)
        count["workers"] = len(client.scheduler_info(n_workers=-1)["workers"])
        begin = time.monotonic()
        for job, done in cluster.results(client, [job for job, _ in todo]):
            kept.keep(job.address, markers[job.address], done)
            failed = [row["failed"] for row in done["rows"] if "failed" in row]
            count["recordings"], count["failed"] = (
                count["recordings"] + 1,
                count["failed"] + bool(failed),
            )
            count["samples"] += max(row.get("samples", 0) for row in done["rows"])
            count["worker_s"] += done["seconds"]
            count["cpu_s"] += done["cpu_s"]
            count["wall_s"] = time.monotonic() - begin
            if failed:
                progress(f"{job.address}: {failed[0]}")
            if time.monotonic() - told > TOLD_S or count["recordings"] == len(todo):
                told = time.monotonic()
                left = (len(todo) - count["recordings"]) * count["wall_s"] / count["recordings"]
                progress(
                    f"{count['recordings']} of {len(todo)}, "
                    f"{count['recordings'] / count['wall_s']:.2g} per second, "
                    f"{left:.0f} s remaining"
                )
    return count


def rows_of(
    work: Sequence[jobs.Job], kept: store.Store, pattern: re.Pattern[str] | None, version: str
) -> Iterator[Row]:
    """The rows of all recordings, done now or before."""
    for job in work:
        found = kept.kept(job.address)
        for row in found["rows"] if found else [{"failed": "not done"}]:
            yield {
                "file": job.address,
                "batch": batch_of(pattern, job.address),
                "seconds": found["seconds"] if found else None,
                "davar": version,
                "table_version": store.TABLE_VERSION,
                **row,
            }


def judge(test: limits.Test | None, rows: Sequence[Row], path: str) -> Found | None:
    """Puts pass or fail into the rows; what the limits come to."""
    if test is None:
        return None
    limits.check_names(test, population.names_of(rows), path)
    for row in rows:
        row["limits"], row["why"] = limits.outcome(test, row)
    stated = limits.stated(test, rows)
    typical = [one["median_unit"] for one in stated if one["median_unit"] is not None]
    return {
        "file": str(path),
        "at_limit": test.at_limit,
        "adequate": test.adequate,
        "stated": stated,
        "typical_unit": sum(typical) + (CHANCE.adequate_p if test.adequate else 0.0),
        **{
            word: sum(row["limits"] == word for row in rows)
            for word in ("pass", "fail", "no result")
        },
    }


def found_in(rows: Sequence[Row], counted: Counted, judged: Found | None, version: str) -> Found:
    """Everything that --json and the page say."""
    good = [row for row in rows if "failed" not in row]
    said = population.summarised(good)
    files_failed = {row["file"]: row["failed"] for row in rows if "failed" in row}
    return {
        "recordings": len({row["file"] for row in rows}),
        "rows": len(good),
        "failed": [{"file": name, "reason": why} for name, why in sorted(files_failed.items())],
        "batches_seen": {
            batch: len(part) for batch, part in population.groups(good, "batch").items()
        },
        "verdicts": {
            verdict: len(part) for verdict, part in population.groups(good, "verdict").items()
        },
        "adequacy": {word: len(part) for word, part in population.groups(good, "adequacy").items()},
        "named_alone": named_alone(good),
        **said,
        "limits": judged,
        "chance": sum("chance" in row for row in good),
        "done_now": counted,
        "davar": version,
        "table_version": store.TABLE_VERSION,
        "versions": {
            name: importlib.metadata.version(name)
            for name in ("dask", "distributed", "fsspec", "pyarrow")
        },
    }


def named_alone(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """batch -> verdict -> units, of units whose own recording names an effect."""
    return {
        batch: {
            kind: len(own)
            for kind, own in population.groups(part, "verdict").items()
            if kind != "none"
        }
        for batch, part in population.groups(rows, "batch").items()
    }


@contextlib.contextmanager
def ended_like_ctrl_c() -> Iterator[None]:
    """SIGTERM ends the work as Ctrl-C does, workers too."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def run(options: Namespace, progress: Progress, emit: Emit) -> int:
    """The command. Exit status 0: all is well; 1: a file failed, a unit failed its limits, or a
    batch lacks something.
    """
    if str(options.model).endswith((".yaml", ".yml")):
        raise BadInput(
            f"{options.model}: not a model file (TOML). davarlab sheet --kalibr makes one"
        )
    model, pattern = models.read(options.model), pattern_of(options.batch)
    models.check_noise(model, options.model)
    test = limits.read(options.limits) if options.limits else None
    kept, version = store.Store(options.folder), contents.versions()["davar"]
    work = work_of(
        options,
        [address for address in sources.expanded(options.files) if not kept.holds(address)],
        model,
    )
    if not work:
        raise BadInput("fleet: no recordings")
    todo = undone(work, kept, version, progress)
    try:
        with ended_like_ctrl_c():
            counted = advance(options, todo, kept, version, progress)
    except KeyboardInterrupt:
        progress(
            f"stopped. Finished recordings are in {kept.units}. The same command "
            "continues from there"
        )
        return STOPPED
    return finish(options, work, kept, pattern, version, test, counted, progress, emit)


def finish(
    options: Namespace,
    work: Sequence[jobs.Job],
    kept: store.Store,
    pattern: re.Pattern[str] | None,
    version: str,
    test: limits.Test | None,
    counted: Counted,
    progress: Progress,
    emit: Emit,
) -> int:
    from . import page  # the pictures take a second to load

    rows = list(rows_of(work, kept, pattern, version))
    good = [row for row in rows if "failed" not in row]
    judged = judge(test, good, options.limits)
    progress("analysing the population")
    found = found_in(rows, counted, judged, version)
    store.write_table(rows, kept.folder / "fleet.parquet")
    progress("drawing the page")
    page.write(page.contents_of(options, rows, found), kept.folder / "fleet.html")
    files.write_whole(
        kept.folder / "fleet.json", json.dumps(values.plain(found), indent=2).encode()
    )
    emit(options, found, page.text(found, kept.folder))
    wrong = (
        found["failed"]
        or any(one["found"] for one in found["hidden"])
        or judged
        and judged["pass"] < len(good)
    )
    return 1 if wrong else 0
