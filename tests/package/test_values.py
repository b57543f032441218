"""davar.adev compared with published values, AllanTools, and the definition."""

import importlib
import math
import resource
import signal

import allantools
import numpy as np
import pytest
from spectra import SPECTRA, allan_variance, shaped
from together import by_definition, davar

# NIST SP 1065 (Riley 2008), table 31: 1000 points, overlapping Allan deviation at tau 1, 10, 100 s;
# table 30: 9 points, tau 1, 2 s.
POINTS_1000 = {1: "2.922319e-01", 10: "9.159953e-02", 100: "3.241343e-02"}
POINTS_9 = {1: "91.22945", 2: "85.95287"}
NINE = np.array([892.0, 809, 823, 798, 671, 644, 883, 903, 677])
SIZES = (1, 2, 3, 7, 16, 50)


def thousand_points():
    """The 1000 points of NIST SP 1065, 12.4: a prime modulus generator."""
    found = [1234567890]
    while len(found) < 1000:
        found.append(16807 * found[-1] % 2147483647)
    return np.array(found) / 2147483647


def test_the_published_points():
    found = davar.adev(thousand_points(), 1.0, clusters=list(POINTS_1000))
    assert [f"{value:.6e}" for value in found.adev] == list(POINTS_1000.values())
    assert found.n.tolist() == [999, 981, 801]
    assert found.taus_s.tolist() == [1, 10, 100]
    found = davar.adev(NINE, 1.0, clusters=list(POINTS_9))
    assert [f"{value:.5f}" for value in found.adev] == list(POINTS_9.values())


def expect_allantools(found, x, rate_hz, taus, rtol=2e-8):
    theirs = allantools.oadev(x, rate=rate_hz, data_type="freq", taus=taus)
    # AllanTools continues until one difference remains, words end at a ninth of the record
    there = slice(None) if not isinstance(taus, str) else theirs[0] * rate_hz < len(x) // 9 + 0.5
    np.testing.assert_allclose(found.taus_s, theirs[0][there], rtol=1e-12)
    np.testing.assert_allclose(found.adev, theirs[1][there], rtol=rtol)
    np.testing.assert_array_equal(found.n, theirs[3][there])


def test_every_octave_and_count_of_differences():
    noise = np.random.default_rng(1)
    for x in (
        noise.normal(0.3, 0.2, 20_001),
        np.cumsum(noise.normal(0, 1e-3, 20_000)) + 1e4,
        noise.normal(0, 1e-12, 5000),
    ):
        found = davar.adev(x, 50.0)
        expect_allantools(found, x, 50.0, found.taus_s)
        assert np.all((found.low < found.adev) & (found.adev < found.high))


@pytest.mark.parametrize("rate_hz", (1.0, 50.0, 99.37))
def test_the_words_and_the_seconds_of_allantools_mean_the_same_here(rate_hz):
    x = np.random.default_rng(9).normal(0.3, 0.2, 3000)
    for taus in ("octave", "decade", "all"):
        expect_allantools(davar.adev(x, rate_hz, taus=taus), x, rate_hz, taus)
    seconds = np.geomspace(1.2 / rate_hz, 1000 / rate_hz, 40)
    expect_allantools(davar.adev(x, rate_hz, taus_s=seconds), x, rate_hz, seconds)
    seconds = davar.adev(x, 50.0, taus_s=[1, 10])
    assert seconds.taus_s.tolist() == [1, 10]
    np.testing.assert_array_equal(davar.adev(x, 50.0, clusters=[50, 500]), seconds)


def expect(found, x, gaps=(), rtol=1e-8):
    expected = [by_definition(x, m, gaps) for m in SIZES]
    np.testing.assert_allclose(found.adev, [value for value, _ in expected], rtol=rtol)
    assert found.n.tolist() == [n for _, n in expected]


def test_gaps_in_every_form():
    x = np.random.default_rng(3).normal(0, 1, 700)
    holes = x.copy()
    holes[[0, 100, 101, 102, 350, 699]] = np.nan
    time_s = np.arange(700) / 10.0
    time_s[300:] += 0.7
    for samples, options, gaps in (
        (holes, {}, []),
        (x, {"gaps": [200, 201, 450]}, [200, 201, 450]),
        (x, {"time_s": time_s}, [300]),
        (x, {"gaps": [200], "time_s": time_s}, [200, 300]),
        (holes, {"gaps": [101, 200]}, [200]),
    ):
        expect(davar.adev(samples, 10.0, clusters=SIZES, **options), samples, gaps)


@pytest.mark.parametrize("gaps", ([], [7, 8191, 8192, 8193]))
@pytest.mark.parametrize("largest", (1, 2**15, 2**31, 2**41))
def test_long_records_have_every_bit_of_the_exact_sums(largest, gaps):
    """Compares with sums of Python's whole numbers, which have no limit. Some exceed 64 bits."""
    sizes = [1, 2, 3, 64, 1000, 4095, 4096, 4097, 8192, 10_000, 15_000]
    draw = np.random.default_rng([12, largest, len(gaps)])
    counts = draw.integers(-largest, largest, 40_000, endpoint=True)
    counts[:200] = largest
    found = davar.adev(counts, 10.0, clusters=sizes, lsb=1.0, gaps=gaps)
    squares, number = [0] * len(sizes), [0] * len(sizes)
    for part in np.split(counts, gaps):
        total = np.concatenate([[0], np.cumsum(part)])
        for t, m in enumerate(sizes):
            differences = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
            squares[t] += sum(d * d for d in map(int, differences))
            number[t] += max(len(differences), 0)
    assert found.n.tolist() == number
    assert found.adev.tolist() == [
        math.sqrt(float(s) / (2.0 * n)) / m for s, n, m in zip(squares, number, sizes)
    ]


def test_phase_is_the_rate_form_of_its_differences():
    phase = np.random.default_rng(11).integers(-1000, 1000, 700)
    time_s = np.arange(700) / 8.0
    time_s[400:] += 3
    for options, broken in (
        ({}, []),
        ({"gaps": [300, 301]}, [300, 301]),
        ({"time_s": time_s}, [400]),
    ):
        given = {"rate_hz": 8.0, "clusters": SIZES, "data_type": "phase", **options}
        rates = np.diff(phase) * 8.0
        rates[np.array(broken, int) - 1] = np.nan  # between two samples that are not neighbours
        found = davar.adev(phase.astype(float), **given)
        expect(found, rates)
        np.testing.assert_array_equal(found, davar.adev(rates, 8.0, clusters=SIZES))
        expect(davar.adev(phase, lsb=0.25, **given), rates * 0.25, rtol=1e-14)
    holes = phase.astype(float)
    holes[100] = np.nan
    expect(davar.adev(holes, 8.0, clusters=SIZES, data_type="phase"), np.diff(holes) * 8.0)


def test_only_gaps_give_no_values_and_a_constant_gives_zeros():
    found = davar.adev(np.arange(6.0), 1.0, clusters=[1, 2], gaps=[1, 2, 3, 4, 5])
    assert found.n.tolist() == [0, 0]
    assert np.isnan(found.adev).all() and np.isnan(found.low).all()
    assert davar.adev(np.full(100, 7.25), 1.0).adev.tolist() == [0.0] * 4


def test_intervals_are_those_of_dynamic_for_one_window():
    noise = np.random.default_rng(5)
    x = noise.normal(0, 1, 5000) + 0.1 * np.cumsum(noise.normal(0, 1, 5000))
    found = davar.adev(x, 100.0)
    options = {"law": "fixed", "mode": "trailing", "segment": 0, "grow": 1, "details": True}
    options |= {"window_max": 5000, "window_min": 5000, "stride": 5000, "bandwidth": "none"}
    there = davar.dynamic(x, 100.0, **options)
    for name, values in {
        "adev": found.adev,
        "adev_low": found.low,
        "adev_high": found.high,
        "differences": found.n,
    }.items():
        wanted = [there[f"{name}_{m}"][0] for m in there.clusters]
        np.testing.assert_allclose(values, wanted, rtol=1e-6)


@pytest.fixture
def library():
    return importlib.import_module("davar._library")


@pytest.mark.parametrize("word, gaps", [("all", None), ("octave", None), ("all", [700, 1500])])
def test_pieces_of_the_sizes_give_the_same_bits(library, monkeypatch, word, gaps):
    x = np.random.default_rng(5).normal(0.3, 0.2, 2000).cumsum()
    whole = davar.adev(x, 50.0, word, gaps=gaps)
    for sizes in (1, 2, 7):
        monkeypatch.setattr(library, "PIECE", sizes * len(x))
        np.testing.assert_array_equal(davar.adev(x, 50.0, word, gaps=gaps), whole)


@pytest.mark.parametrize("count, taus", [(2, 1), (10**6, 111_111), (10**8, 24), (1 << 31, 31)])
def test_a_piece_has_every_size_once_and_a_bounded_number_of_differences(library, count, taus):
    sizes = np.arange(taus)
    pieces = [sizes[some] for some in library.pieces(count, taus)]
    np.testing.assert_array_equal(np.concatenate(pieces), sizes)
    assert all(len(one) == 1 or len(one) * count <= library.PIECE for one in pieces)


RECORD_WAYS = {
    "slide": {"law": "fixed", "segment": 0},
    "slide without fit": {"law": "fixed", "segment": 0, "fit_every": 0},
    "slide, a fit in ten": {"law": "fixed", "segment": 0, "fit_every": 10},
    "push": {"law": "or"},
    "push of a fixed window": {"law": "fixed"},
    "push with a stride": {"law": "fixed", "stride": 7},
    "push around a gap": {"law": "fixed", "gaps": [4321]},
    "slide around gaps": {"law": "fixed", "segment": 0, "gaps": [4321, 4400, 8999]},
}


@pytest.mark.parametrize("way", RECORD_WAYS)
def test_pieces_of_a_record_give_the_same_bits(library, monkeypatch, way):
    x = np.random.default_rng(6).normal(0.3, 0.2, 9000)
    words = {"lsb": 0.01, "bandwidth": "none", **RECORD_WAYS[way]}
    whole = davar.dynamic(x, 50.0, **words)
    for samples in (1000, 2500):
        monkeypatch.setattr(library, "PUSHED", samples)
        pieces = davar.dynamic(x, 50.0, **words)
        assert list(pieces) == list(whole)
        for name in whole:
            np.testing.assert_array_equal(pieces[name], whole[name], err_msg=name)


class Interrupted:
    """The calls of the library; the third of one kind gets Ctrl-C when it ends."""

    def __init__(self, calls, name):
        self.calls, self.name, self.count = calls, name, 0

    def __getattr__(self, name):
        found = getattr(self.calls, name)
        return self.interrupt(found) if name == self.name else found

    def interrupt(self, function):
        def call(*given):
            written = function(*given)
            self.count += 1
            if self.count == 3:
                signal.raise_signal(signal.SIGINT)
            return written

        return call


@pytest.mark.parametrize("way", ["slide", "slide without fit", "push"])
def test_ctrl_c_ends_a_record_after_the_present_piece(library, monkeypatch, way):
    name = way.partition(" ")[0]
    calls = Interrupted(library.calls(), f"davar_python_{name}")
    monkeypatch.setattr(library, "calls", lambda: calls)
    monkeypatch.setattr(library, "PUSHED", 1000)
    x = np.random.default_rng(7).normal(0, 0.2, 9000)
    with pytest.raises(KeyboardInterrupt):
        davar.dynamic(x, 50.0, lsb=0.01, bandwidth="none", **RECORD_WAYS[way])
    assert calls.count == 3


def test_ctrl_c_ends_it_after_the_present_piece(library, monkeypatch):
    done, piece_of = [], library.piece_of

    def interrupted(*given):
        found = piece_of(*given)
        done.append(len(given[-1]))
        if len(done) == 3:
            signal.raise_signal(signal.SIGINT)
        return found

    monkeypatch.setattr(library, "piece_of", interrupted)
    monkeypatch.setattr(library, "PIECE", 8000)
    with pytest.raises(KeyboardInterrupt):
        davar.adev(np.arange(1000.0), 1.0, "all")
    assert done == [8, 8, 8]


@pytest.mark.parametrize(
    "taus, seed, records, sizes, margin",
    (
        ("octave", 7, 600, None, 0.03),  # 0.95 within three of sqrt(0.95 0.05 / 600)
        ("all", 12, 300, 111, 0.05),  # four of sqrt(0.95 0.05 / 300), more sizes than a fit takes
    ),
)
def test_intervals_cover_the_truth_in_white_noise(taus, seed, records, sizes, margin):
    noise, inside = np.random.default_rng(seed), []
    for _ in range(records):
        found = davar.adev(noise.normal(0, 1, 1000), 1.0, taus=taus)
        truth = 1 / np.sqrt(found.taus_s)
        inside.append((found.low <= truth) & (truth <= found.high))
    share = np.mean(inside, axis=0)
    assert share.size == (sizes or share.size)
    assert np.all(np.abs(share - 0.95) < margin), share


# --- intervals in noise that is neither white nor a power of tau ---

WINDOW = 1024


def covered(limits, spectrum, sizes):
    """How many of the limits (records, 2, sizes) contain the truth, and their median ratio."""
    truth = np.sqrt([allan_variance(spectrum, m) for m in sizes])
    low, high = np.moveaxis(np.array(limits), 1, 0)
    return np.mean((low <= truth) & (truth <= high), axis=0), np.median(high / low, axis=0)


def of_windows(x, mode):
    """The limits of windows that do not overlap."""
    sizes = 2 ** np.arange(7)
    options = {"law": "fixed", "segment": 0, "stride": WINDOW, "lsb": 0.05, "bandwidth": "none"}
    options |= {"window_max": WINDOW, "window_min": WINDOW, "clusters": sizes, "details": True}
    found = davar.dynamic(x, 1000.0, mode=mode, **options)
    columns = [[found[f"adev_{end}_{m}"] for m in sizes] for end in ("low", "high")]
    return np.array(columns).transpose(2, 0, 1), sizes


def of_records(x):
    found = [davar.adev(one, 1.0) for one in x.reshape(-1, WINDOW)]
    return [(one.low, one.high) for one in found], np.rint(found[0].taus_s).astype(int)


HOW = {
    "trailing": lambda x: of_windows(x, "trailing"),
    "centred": lambda x: of_windows(x, "centred"),
    "record": of_records,
}


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("name", SPECTRA)
@pytest.mark.filterwarnings("ignore:.*withheld")
def test_intervals_hold_next_to_lines_and_in_motion(name, how):
    random = np.random.default_rng([21, list(SPECTRA).index(name), list(HOW).index(how)])
    limits, sizes = HOW[how](shaped(random, SPECTRA[name], 400 * WINDOW))
    share, ratio = covered(limits, SPECTRA[name], sizes)
    # 0.90 within three of sqrt(0.9 0.1 / 400)
    assert np.all(share > 0.90 - 0.045), share
    assert np.all(ratio < 2.5), ratio


def test_a_flight_before_changes_no_interval():
    random, window = np.random.default_rng(23), 64 * 156
    rest = 0.2 * random.normal(size=2 * window) + 2e-3 * np.cumsum(random.normal(size=2 * window))
    flight = np.rint(2e5 * np.sin(2 * np.pi * 0.003 * np.arange(30 * window))) * 1e-3
    options = {"law": "fixed", "mode": "trailing", "segment": 0, "lsb": 1e-3, "bandwidth": "none"}
    options |= {"window_max": window, "window_min": window, "stride": window, "details": True}
    alone = davar.dynamic(rest, 100.0, **options)
    after = davar.dynamic(np.concatenate([flight, rest]), 100.0, **options)
    for m in alone.clusters:
        for name in (f"adev_low_{m}", f"adev_high_{m}"):
            assert after[name][-1] == pytest.approx(alone[name][-1], rel=1e-6), name


def test_noise_below_half_a_count_has_no_limits():
    found = davar.adev(np.rint(np.random.default_rng(24).normal(0, 0.2, 5000)), 100.0, lsb=1.0)
    assert np.all(found.low == 0) and np.all(np.isinf(found.high))


def test_no_memory_is_kept_for_fits_that_are_not_made():
    stream = davar.Stream(100.0, lsb=0.01, stride=500, details=True, fit_every=7)
    counts = np.rint(np.random.default_rng(25).normal(0, 20, 100_000)).astype(int)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(20):
        stream.push(counts)
        stream.results()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 30_000  # kB
