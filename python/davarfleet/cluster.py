"""The jobs on Dask: two processes of this machine, or the workers of a scheduler that is there."""

import contextlib
import logging
import signal
import threading
import warnings
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import TYPE_CHECKING

from davarlab.errors import BadInput, of_extra

from . import job as jobs
from .store import Done

if TYPE_CHECKING:
    from distributed import Client

WAIT_S = 30  # for a scheduler to answer


@contextlib.contextmanager
def client(address: str | None, workers: int) -> Iterator["Client"]:
    """A Dask client. Raises BadInput when no scheduler answers, or it has no workers."""
    with of_extra("fleet"):
        import dask
        from dask import distributed

    quiet = {
        "distributed.scheduler.allowed-failures": 1,
        "distributed.comm.timeouts.connect": WAIT_S,
        "distributed.admin.log-format": "%(message)s",
    }
    with dask.config.set(quiet), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        if address:
            with remote(distributed, address) as found:
                yield found
            return
        with deaf():
            local = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
        with local, distributed.Client(local) as found:
            yield found


@contextlib.contextmanager
def deaf() -> Iterator[None]:
    """Processes that start in the block do not hear Ctrl-C, which a terminal sends to all: this one
    ends them.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def remote(distributed: ModuleType, address: str) -> Iterator["Client"]:
    try:
        found = distributed.Client(address, timeout=WAIT_S)
    except (OSError, ValueError, TimeoutError) as why:
        raise BadInput(
            f"--scheduler {address}: no answer ({' '.join(str(why).split())[:120]})"
        ) from None
    with found:
        if not found.scheduler_info()["workers"]:
            raise BadInput(f"--scheduler {address}: it has no workers")
        yield found


def version() -> str:
    from davarlab.report import contents

    return contents.versions()["davar"]


def check_versions(found: "Client", own: str) -> None:
    """Raises BadInput unless every worker has this davarlab."""
    try:
        there = found.run(version)
    except Exception as why:  # whatever a worker raises that lacks the package
        raise BadInput(
            f"--scheduler: a worker cannot run davarlab ({' '.join(str(why).split())[:120]})"
        ) from None
    for worker, other in there.items():
        if other != own:
            raise BadInput(f"--scheduler: worker {worker} has davar {other}, this is {own}")


def results(found: "Client", work: Sequence[jobs.Job]) -> Iterator[tuple[jobs.Job, Done]]:
    """(job, what measured() made of it) as they come; a worker that dies of a file twice is that
    file's failure.
    """
    from dask import distributed

    futures = {
        found.submit(jobs.measured, job, pure=False, key=f"davar-{place}-{id(work)}"): job
        for place, job in enumerate(work)
    }
    for future in distributed.as_completed(futures):
        if future.status == "finished":
            done: Done = future.result()
        else:
            why = future.exception()
            done = {
                "rows": [{"failed": f"its worker died ({type(why).__name__})"}],
                "seconds": 0.0,
                "cpu_s": 0.0,
                "again": True,
            }
        yield futures.pop(future), done
        future.release()
