"""How a process computes: the same numbers whatever the machine is busy with and however many
processors it has, in memory that it keeps."""

import ctypes
import functools

import threadpoolctl

# Of mallopt (malloc.h of glibc), in bytes; 32 MiB are the most that it takes for mmap.
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
KEPT, MAPPED = 1 << 27, 1 << 25


@functools.cache
def prepared() -> None:
    """For this process, once numpy and scipy are loaded, whatever its environment says.

    Sums of the linear algebra go in one order: with more threads, or as many as happen to be free,
    their last digits differ. Where the C library is glibc, an array that is freed stays for the
    next one; otherwise its pages go back to the system, and the next array is filled page by page
    again: a fifth of the time of `improve`."""
    threadpoolctl.threadpool_limits(1)
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt:
        mallopt(TRIM_THRESHOLD, KEPT)
        mallopt(MMAP_THRESHOLD, MAPPED)
