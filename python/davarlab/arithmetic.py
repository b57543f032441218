"""The same numbers whatever the machine is busy with and however many processors it has."""

import functools

import threadpoolctl


@functools.cache
def on_one_thread() -> None:
    """Sums of the linear algebra go in one order: with more threads, or as many as happen to be
    free, their last digits differ. For this process, once numpy and scipy are loaded, whatever its
    environment says."""
    threadpoolctl.threadpool_limits(1)
