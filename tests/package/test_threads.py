"""One Stream, many threads: no crash, and the results match some order of complete blocks."""

import copy
import pickle
import signal
import threading

import numpy as np
import pytest
from scipy.signal import lfilter
from together import davar, expect_equal

OPTIONS = {"lsb": 0.01, "stride": 10, "law": "glr", "window_max": 1000, "segment": 0}


def in_threads(count, work):
    """Exceptions of work(i), all run concurrently."""
    raised, ready = [], threading.Barrier(count)

    def one(i):
        ready.wait()
        try:
            work(i)
        except BaseException as why:
            raised.append(why)

    threads = [threading.Thread(target=one, args=(i,)) for i in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return raised


def test_blocks_are_pushed_completely_and_each_result_comes_once():
    """Every thread pushes copies of the same block, so that the order does not matter."""
    block = np.random.default_rng(1).integers(-100, 100, 2000)
    stream, taken = davar.Stream(100.0, **OPTIONS), []

    def work(_):
        for _ in range(50):
            stream.push(block)
            taken.append(stream.results())
            assert stream.health["gaps"] >= 0

    assert in_threads(4, work) == []
    stream.finish()
    taken.append(stream.results())
    order = np.argsort(np.concatenate([one.epoch for one in taken]))
    whole = davar.dynamic(np.tile(block, 200), 100.0, **OPTIONS)
    expect_equal(
        {name: np.concatenate([one[name] for one in taken])[order] for name in whole}, whole
    )


def test_filters_that_are_learned_at_the_same_time():
    noise, learned = np.random.default_rng(4).normal(0, 1, 20_000), {}
    recordings = [lfilter([1 - pole], [1, -pole], noise) for pole in (0.2, 0.4, 0.6, 0.8)]

    def work(i):
        learned[i] = davar.dynamic(recordings[i], 100.0, lsb=0.01, bandwidth="auto").bandwidth

    assert in_threads(4, work) == []
    for i, recording in enumerate(recordings):
        alone = davar.dynamic(recording, 100.0, lsb=0.01, bandwidth="auto").bandwidth
        assert learned[i] == alone and alone.startswith("ba:")


def test_gaps_and_the_end_from_other_threads():
    stream = davar.Stream(100.0, full_scale=1.0)
    x = np.random.default_rng(2).normal(0, 0.1, 3000)
    stream.push(x)  # a gap counts only between samples
    raised = in_threads(
        4, lambda i: [stream.gap(1) if i == 0 else stream.push(x) for _ in range(20)]
    )
    assert raised == []
    stream.push(x)
    assert in_threads(4, lambda i: stream.finish()) == []
    refused = in_threads(3, lambda i: stream.push(x))
    assert [type(why) for why in refused] == [ValueError] * 3
    assert 1 <= stream.health["gaps"] <= 20


def test_an_array_that_pushes_while_it_is_read():
    stream = davar.Stream(100.0, lsb=0.01)

    class Late:
        def __array__(self, dtype=None, copy=None):
            stream.push(np.zeros(5, np.int64))
            return np.ones(3, np.int64)

    stream.push(Late())
    assert stream.push(np.arange(1)) == 0
    assert stream._feed.taken == 9


def test_a_signal_handler_cannot_interfere():
    """It runs between two steps of a call. Its own call is rejected or done completely."""
    block, said = np.random.default_rng(3).integers(-100, 100, 500), {"done": 0, "refused": 0}
    stream = davar.Stream(100.0, lsb=0.01, stride=10)

    def handler(number, frame):
        try:
            stream.push(block)
            said["done"] += 1
        except RuntimeError as why:
            assert "signal handler" in str(why)
            said["refused"] += 1
        signal.setitimer(signal.ITIMER_REAL, 0.001)

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.001)
        pushed = 0
        while pushed < 200 or (said["done"] < 5 and pushed < 20_000):
            stream.push(block)
            pushed += 1
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    stream.finish()
    whole = davar.dynamic(np.tile(block, pushed + said["done"]), 100.0, lsb=0.01, stride=10)
    expect_equal(stream.results(), whole)


@pytest.mark.parametrize("call", (copy.copy, copy.deepcopy, pickle.dumps))
def test_a_copy_is_rejected(call):
    with pytest.raises(TypeError, match="Stream cannot be copied or pickled"):
        call(davar.Stream(100.0, lsb=0.01))
