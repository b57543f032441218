"""The tests of adequacy and the cells of Allan deviations against their exact laws; the slack, the
end and the cost of the search.
"""

from dataclasses import replace
from types import SimpleNamespace
from unittest import mock

import lab_bench
import numpy as np
import pytest
from davarlab.candidates import candidate
from davarlab.diagnosis import cells, evidence, fitting, judge, search
from davarlab.diagnosis import improve as improving
from davarlab.diagnosis.judge import Cell
from davarlab.inference import adequacy, allan, reading
from davarlab.inference.parts import Part
from davarlab.report import verdict
from davarlab.thresholds import CHANCE, JUDGE, SEARCH, TRIES
from scipy import fft, stats


def cell(ratio=1.0, freedom=100.0, tau_s=1.0, start_s=0.0, stop_s=100.0):
    z = float(adequacy.normal_score(np.array(ratio**2), freedom))
    return Cell(tau_s, start_s, stop_s, 0.01 * ratio, 0.01, ratio, z, freedom)


@pytest.mark.parametrize("freedom", [10, 40, 400])
def test_a_normal_score_has_the_chance_of_its_chi_square(freedom):
    for p in (1e-4, 0.02, 0.3, 0.5, 0.8, 0.99, 1 - 1e-4):
        z = adequacy.normal_score(stats.chi2.ppf(p, freedom) / freedom, freedom)
        assert z == pytest.approx(stats.norm.ppf(p), abs=2 / freedom)


def test_p_values_of_white_ordinates_are_evenly_spread():
    """And the whole one is at most what three independent tests give."""
    found = {}
    rng = np.random.default_rng(1)
    for _ in range(250):
        c = rng.standard_normal(12_000)
        told = adequacy.judge(c, 0)
        least = min(told.tests.values())
        assert told.p_value == pytest.approx(1 - (1 - least) ** 3)
        largest = 2 * told.cells.size * stats.norm.sf(np.abs(told.cells).max())
        assert told.tests["largest cell"] == pytest.approx(min(1.0, largest))
        for name, p in told.tests.items():
            found.setdefault(name, []).append(p)
    assert stats.kstest(found["spectrum"], "uniform").pvalue > 1e-3
    assert stats.kstest(found["time and frequency"], "uniform").pvalue > 1e-3
    for name in ("narrow band", "largest cell"):  # the least of many: bounds
        low, high = stats.binom.ppf([1e-4, 1 - 1e-4], 250, 0.2)
        assert low - 30 <= np.sum(np.array(found[name]) < 0.2) <= high


def test_parameters_that_were_fitted_take_their_freedom():
    c = np.random.default_rng(2).standard_normal(12_000)
    found = [adequacy.spectrum_score(c, free) for free in (0, 2, 8)]
    edges = np.unique(np.round(np.geomspace(4, len(c), 70)).astype(int))
    bins = len(edges) - 1
    z2 = stats.chi2.isf(found[0], bins)
    expected = [stats.chi2.sf(z2, bins - free) for free in (0, 2, 8)]
    assert found == pytest.approx(expected, rel=1e-6)
    assert found[0] > found[1] > found[2]


@pytest.mark.parametrize(
    "spoiled, name",
    [
        (lambda c, rng: c * np.linspace(0.9, 1.1, len(c)), "spectrum"),
        (lambda c, rng: c * (1 + 0.2 * (np.abs(np.arange(len(c)) - 5000) < 200)), "narrow band"),
        (lambda c, rng: in_time(c, 1.15), "time and frequency"),
    ],
)
def test_each_test_sees_its_fault(spoiled, name):
    rng = np.random.default_rng(3)
    c = rng.standard_normal(12_000)
    assert adequacy.judge(c, 0).tests[name] > 0.01
    assert adequacy.judge(spoiled(c, rng), 0).tests[name] < 0.01


def in_time(c, growth):
    """Noise that grows in the middle third of the record."""
    y = fft.idct(np.concatenate([[0.0], c]), norm="ortho")
    third = len(y) // 3
    y[third : 2 * third] *= growth
    return fft.dct(y / y.std(), norm="ortho")[1:]


@pytest.mark.parametrize("cells_count", [1, 20])
def test_a_deviation_is_proven_beyond_its_interval_of_99_percent(cells_count):
    """Of the family of cells: a chi-square interval at 1 % / (2 cells) on either side."""
    tail = 0.01 / (2 * cells_count)
    for freedom in (3.0, 30.0, 3000.0):
        low, high = (np.sqrt(stats.chi2.ppf(p, freedom) / freedom) for p in (tail, 1 - tail))
        others = [cell(freedom=freedom)] * (cells_count - 1)
        for ratio, bound in ((1.2 * high, np.log(1.2)), (0.8 * low, np.log(0.8))):
            off = judge.proven([cell(ratio, freedom), *others])
            assert off[0] == pytest.approx(bound, rel=1e-6)
            assert not off[1:].any()
        for ratio in (0.999 * high, 1.001 * low):
            assert judge.proven([cell(ratio, freedom), *others])[0] == 0


def test_the_floor_is_the_error_of_true_models():
    rng = np.random.default_rng(4)
    freedoms = np.array([2.0, 5.0, 30.0, 500.0])
    drawn = [
        judge.error_of([cell(np.sqrt(rng.chisquare(f) / f), f) for f in freedoms]) ** 2
        for _ in range(4000)
    ]
    floor = judge.floor_of([cell(freedom=f) for f in freedoms])
    assert np.sqrt(np.mean(drawn)) == pytest.approx(floor, rel=0.03)
    assert judge.error_of([cell(10.0), cell(0.1), cell(1.0)]) == pytest.approx((2 / 3) ** 0.5)


FINE, SURE = [cell(1.0, 1e4)] * 4, stats.chi2.ppf(1 - CHANCE.family_wise / 10, 1e6) / 1e6
UNSURE = stats.chi2.ppf(CHANCE.family_wise / 10, 1e6) / 1e6
WORDS = [  # word, cells, p, cells of short windows, what spoils the recording
    ("statistical", FINE, 0.5, [], ""),
    ("statistical", FINE, 0.0101, [], ""),
    ("practical", FINE, 0.0099, [], ""),
    ("no", FINE, 0.5, [], "dead_zone"),
    ("no", [], 0.5, [], ""),
    ("statistical", [cell(10 ** (1.3 * judge.floor_of(FINE)), 1e4)] * 4, 0.5, [], ""),
    ("no", [cell(10 ** (1.3 * judge.floor_of(FINE)), 1e4)] * 4, 0.0099, [], ""),
    ("practical", [cell(10 ** (1.2 * judge.floor_of(FINE)), 1e4)] * 4, 0.0099, [], ""),
    *(
        (word, FINE, 0.5, [cell((1 + bound) ** sign * np.sqrt(end), 1e6)], "")
        for sign, end in ((1, SURE), (-1, UNSURE))
        for bound, word in ((0.049, "practical"), (0.051, "no"))
    ),
]


@pytest.mark.parametrize("word, found, p, short, spoiled", WORDS)
def test_the_words_of_the_judge(word, found, p, short, spoiled):
    """Statistical: not proven off, p at least 1 %; practical: proven off by 5 % at most, error at
    most 1.25 floors."""
    assert judge.judged(found, short, p, spoiled).adequacy == word


@pytest.mark.parametrize(
    "model, deviation, density, word",
    [
        (0.300, (0.30, 0.29, 0.31), (0.30, 0.29, 0.31), "statistical"),
        (0.270, (0.30, 0.29, 0.31), (0.30, 0.29, 0.31), "no"),
        (0.280, (0.30, 0.29, 0.31), (0.30, 0.29, 0.31), "statistical"),  # 4 % are proven
        (0.270, (0.30, 0.29, 0.31), (0.28, 0.26, 0.30), "statistical"),  # one does not say so
        (0.340, (0.30, 0.29, 0.31), (0.31, 0.30, 0.32), "no"),
        (0.000, (0.30, 0.29, 0.31), (0.30, 0.29, 0.31), "no"),
        (0.000, (0.01, 0.00, 0.02), (0.01, 0.00, 0.02), "statistical"),
        (0.300, (0.00, 0.00, 0.00), (0.00, 0.00, 0.00), "no"),
    ],
)
def test_a_model_fits_only_with_the_angle_random_walk_of_the_record(
    model, deviation, density, word
):
    found = judge.judged(FINE, [], 0.5, "", reading.Reading(model, deviation, density))
    assert found.adequacy == word
    assert (found.reading.off != 0) == (word == "no" or model == 0.28)
    said = " ".join([verdict.adequacy(found), *verdict.headline(found, 100.0, True)])
    assert "000000" not in said
    assert (said.count("white noise") > 1) == (word == "no")
    assert ("times the white noise of the model" in said) == (word == "no" and model < 0.3)


def test_the_angle_random_walk_that_is_read_covers_the_true_one():
    """Beside flicker noise and a strong line, at 99 %, and from a model whose own value is off."""
    inside = {"deviation": 0, "density": 0}
    tries = 40
    for seed in range(tries):
        state = fitting.judged(fitting.start(*lab_bench.beside_a_line(seed)))
        found = state.judgement.reading
        for name in inside:
            _, low, high = getattr(found, name)
            inside[name] += low < 0.3 < high
        assert not state.judgement.misread
    assert min(inside.values()) >= stats.binom.ppf(1e-4, tries, 0.99)


def test_the_largest_deviation_is_that_of_its_cell():
    said = judge.judged([cell(1.5, 1e4, 2.0), cell(1.2, 1e4, 4.0)], [], 0.5)
    assert (said.largest["tau_s"], said.largest["ratio"]) == (2.0, 1.5)
    assert 44 < said.largest["percent"] < 50
    assert said.farthest == said.largest
    assert judge.judged([], [], 0.5).largest is None


def test_the_longest_tau_that_a_record_confirms():
    """Two one-sided tests at 5 %: |log ratio| + 1.645 errors of the logarithm below log 1.05."""
    need = 2 * (1.645 / 2 / np.log(1.05)) ** 2 * 2  # about: error of a logarithm 1 / sqrt(2 f)
    good, bad = cell(1.0, 1.05 * need / 2, 4.0), cell(1.0, 0.95 * need / 2, 8.0)
    assert judge.shown_to([cell(1.0, 1e5, 1.0), good, bad]) == 4.0
    assert judge.shown_to([cell(1.06, 1e9, 1.0), good]) == 0.0
    assert judge.shown_to([cell(1.04, 1e9, 1.0)]) == 1.0
    quarter = cell(1.0, 1e9, 16.0, 0.0, 25.0)
    assert judge.shown_to([cell(1.0, 1e9, 1.0), quarter]) == 1.0  # the whole record only


@pytest.mark.parametrize("m, window", [(1, 100), (4, 100), (16, 150), (1, 2000), (40, 4000)])
def test_degrees_of_freedom_are_those_of_the_quadratic_form(m, window):
    """Of white noise: twice the squared mean of the estimate over its variance, both exact."""
    count = window - 2 * m + 1
    weights = np.concatenate([-np.ones(m), np.ones(m)])
    lags = np.correlate(weights, weights, "full")[2 * m - 1 :]
    k = np.arange(1, min(count, len(lags)))
    total = count * lags[0] ** 2 + 2 * np.sum((count - k) * lags[k] ** 2)
    exact = (count * lags[0]) ** 2 / total
    power = allan.on_grid(np.ones_like, 50.0)
    found = allan.freedom(np.ones_like, power, m, window, 50.0)
    assert found == pytest.approx(exact, rel=0.05)


@pytest.mark.parametrize("samples", [2, 7, 100])
def test_expected_variances_are_those_of_the_definition(samples):
    """Of white noise sigma^2 / m; of a walk the sum over its steps."""
    power = allan.on_grid(np.ones_like, 50.0)
    assert allan.expected(power, [samples])[0] == pytest.approx(1 / samples, rel=2e-3)
    walk = allan.on_grid(lambda f: 1 / (2 * np.sin(np.pi * f / 50)) ** 2, 50.0)
    m = samples
    steps = np.concatenate([np.arange(1, m + 1), np.arange(m - 1, 0, -1)]) / m
    assert allan.expected(walk, [m])[0] == pytest.approx(np.sum(steps**2) / 2, rel=2e-3)


def test_short_windows_and_octaves():
    for window, longest in ((8, 0), (9, 1), (1000, 64), (36 * 16, 64), (36 * 16 - 1, 32)):
        assert [0, *allan.octaves(window)][-1] == longest


def test_chance_of_a_gain():
    """Twice a gain is a chi-square of one degree of freedom, tried so many times."""
    for gain in (0.0, 1.0, 8.0, 30.0):
        p = min(1.0, 5 * stats.chi2.sf(2 * gain, 1))
        assert candidate.log_tail(gain, 5) == pytest.approx(np.log(p), abs=1e-9)


def of_line(kind, gain, samples, f_hz=10.0):
    data = SimpleNamespace(samples=samples, rate_hz=50.0)
    return candidate.log_tail_of_line(Part(kind, {"frequency_hz": f_hz}), gain, data)


def test_chance_of_a_line():
    """All sharp lines together, of any number of turns, have at most their share of it."""
    for gain, samples in ((20.0, 1e5), (40.0, 3e6)):
        assert of_line("sinusoid", gain, 2 * samples) - of_line(
            "sinusoid", gain, samples
        ) == pytest.approx(np.log(2))
    samples = 20_000
    turns = np.arange(1, samples + 1) / 2  # one test at each ordinate
    chances = [of_line("sinusoid", 30.0, samples, one * 50.0 / samples) for one in turns]
    each = np.exp(np.array(chances) + 30.0) / TRIES.of_kind["sinusoid"]
    assert 0.5 < np.sum(1 / each) < 2  # weights of a bound by Bonferroni
    assert of_line("sinusoid", 15.0, samples, 2 * 50.0 / samples) < np.log(1e-4)
    assert of_line("sinusoid", 15.0, samples) > np.log(1e-2)
    twice = of_line("narrow_band", 30.0, 20_000)
    once = of_line("narrow_band", 30.0, 10_000)
    assert once == pytest.approx(np.log(150) - 30)
    assert twice - once == pytest.approx(0.4 * np.log(2))


# The slack of the search: 0.02 of the floor. Errors beside a floor of 0.5: a slack of 0.01.


class Stand:
    """A state of the search with an error, by its parts."""

    def __init__(self, parts, role="spectrum"):
        self.parts = [SimpleNamespace(kind=one, role=role, form="raw") for one in parts]
        self.judgement = SimpleNamespace(adequacy="no")
        self.spoiled = ""


@pytest.fixture
def errors(monkeypatch):
    """error by the number of parts; nothing but the error counts."""
    table = {}
    monkeypatch.setattr(search, "errors_of", lambda state: (table[len(state.parts)], 0.5))
    monkeypatch.setattr(search, "with_parts", rest_of)
    for name in ("certain", "settles", "by_chance"):
        monkeypatch.setattr(search, name, lambda *_: False)
    return table


def rest_of(state, parts):
    made = Stand([])
    made.parts = list(parts)
    return made


@pytest.mark.parametrize("earns", [False, True])
@pytest.mark.parametrize("off", [-0.0101, -0.0099, 0.0, 0.0099, 0.0101])
def test_a_part_stays_if_it_raises_the_error_by_the_slack_at_most(errors, monkeypatch, off, earns):
    """One that must earn its place stays only if it lowers the error by as much."""
    monkeypatch.setattr(search, "earning", lambda part, rest: earns)
    errors |= {1: 0.1, 2: 0.1 + off}
    state, kept, useless, _ = search.useful(Stand("ab"), 1)
    stays = off <= (-0.01 if earns else 0.01)
    assert ([part.kind for part in kept], len(useless)) == ((["b"], 0) if stays else ([], 1))
    assert len(state.parts) == 1 + stays


@pytest.mark.parametrize("off, goes", [(-0.0101, False), (-0.0099, True), (0.0099, True)])
def test_a_part_by_chance_goes_if_the_error_rises_by_the_slack_at_most(
    errors, monkeypatch, off, goes
):
    """off: of the error with the part from that without."""
    monkeypatch.setattr(search, "earning", lambda part, rest: False)
    monkeypatch.setattr(search, "by_chance", lambda state, part, rest: part.kind == "b")
    errors |= {3: 0.1 + off, 2: 0.1}
    _, kept, _, outdone = search.useful(Stand("abc"), 1)
    assert [part.kind for part in outdone] == (["b"] if goes else [])
    assert "c" in [part.kind for part in kept] or off > 0.01


@pytest.mark.parametrize(
    "before, after, certain, accepted",
    [
        (("no", 0.10), ("statistical", 0.1009), False, True),  # within 0.02 floors
        (("no", 0.10), ("statistical", 0.1011), False, False),
        (("no", 0.05), ("statistical", 0.0624), False, True),  # as far as a true model's
        (("no", 0.05), ("statistical", 0.0626), False, False),
        (("statistical", 0.04), ("no", 0.041), True, False),
        (("statistical", 0.04), ("statistical", 0.0499), True, True),  # below the floor
        (("statistical", 0.04), ("statistical", 0.0501), True, False),
        (("statistical", 0.04), ("statistical", 0.0499), False, False),
    ],
)
def test_an_error_that_rose_by_chance_is_accepted(before, after, certain, accepted):
    """The floor is 0.05. certain: no chance explains what the last model has more."""
    given, last = (judge.Judgement(*one, 0.05, 0.5, None, 1.0) for one in (before, after))
    assert improving.rise_is_chance(last, given, certain) is accepted


def test_the_error_of_a_true_model_is_near_its_floor():
    made = lab_bench.simulated(seconds=400.0)
    judged = fitting.judged(fitting.start(made, lab_bench.model()))
    assert 0.4 < judged.judgement.error / judged.judgement.floor < 1.25
    assert judged.judgement.adequacy == "statistical"
    assert {part.kind for part in judged.parts} == {"angle_random_walk", "bias_instability"}
    windows = {round((one.stop_s - one.start_s) / 400.0, 3) for one in judged.cells}
    assert windows == {1.0, 0.25, 0.062}
    assert JUDGE.tolerance == 1.05
    assert Part("angle_random_walk").role == "spectrum"


def test_heavy_tails_scatter_the_energies_of_wide_bands():
    """Excess kurtosis k in a band that is a share s of all: a freedom less by 1 + k s / 2."""
    c = np.random.default_rng(7).standard_normal(12_000)
    plain, heavy = adequacy.cells_of(c), adequacy.cells_of(c, 2.0)
    ratio = heavy.std(axis=1) / plain.std(axis=1)
    assert ratio[-1] == pytest.approx(1.5**-0.5, rel=0.02)  # the upper half of the band
    assert ratio[-2] == pytest.approx(1.25**-0.5, rel=0.02)


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0])
def test_a_known_course_makes_a_variance_scatter_less(share):
    """Of a fixed course with white noise: drawn, against the degrees of freedom of the cell."""
    rng, count = np.random.default_rng(8), 50
    course = np.full(count, np.sqrt(1 - share))
    drawn = np.mean((course + np.sqrt(share) * rng.standard_normal((40_000, count))) ** 2, axis=1)
    one = np.array([1.0])
    (found,) = cells.row_cells(0, 450, [50], one, share * one, (1 - share) * one, count * one, 50.0)
    assert found.freedom == pytest.approx(2 / drawn.var(), rel=0.04)
    assert (found.ratio, found.tau_s, found.stop_s) == (1.0, 1.0, 9.0)


def test_a_white_level_that_changes_scales_the_cells():
    made = lab_bench.simulated(seconds=100.0)
    state = fitting.start(made, lab_bench.model(b=0.01))
    plain, grown = (
        cells.cells_of(state, state.record, np.full(made.samples, level)) for level in (1.0, 2.0)
    )
    shortest = min(one.tau_s for one in plain)
    for one, two in zip(plain, grown):
        if one.tau_s == shortest:
            assert two.model_dps**2 / one.model_dps**2 == pytest.approx(2, rel=0.05)


@pytest.mark.parametrize("loss, goes", [(2.9, True), (3.1, False)])
def test_a_term_that_a_later_one_made_needless_goes(errors, monkeypatch, loss, goes):
    """Within three of the log-likelihood a recording cannot tell two models."""
    monkeypatch.setattr(search, "loss_without", lambda state, rest, part: loss)
    left = search.pruned(Stand("abc", "mean"), 1)
    assert "".join(part.kind for part in left.parts) == ("ac" if goes else "abc")


@pytest.mark.parametrize("error, worse", [(0.0374, False), (0.0376, True), (0.031, False)])
def test_a_held_out_error_is_worse_above_the_floor_of_a_true_model(error, worse):
    before, after = (
        improving.Step(None, [], 0.1, 0.03, outside, 0.5, 0.03) for outside in (0.035, error)
    )
    assert improving.worse_held_out(before, after) is worse


@pytest.mark.parametrize(
    "error, loss, kept", [(0.5, 51, True), (0.5, 49, False), (0.51, 51, False)]
)
def test_a_line_that_no_averaging_time_shows_is_certain(monkeypatch, error, loss, kept):
    monkeypatch.setattr(search, "loss_without", lambda state, rest, part: loss)
    monkeypatch.setattr(search, "earning", lambda part, rest: False)
    assert search.certain(Stand("ab"), None, Stand("a"), error, 0.5) is kept


@pytest.mark.parametrize("loss, chance", [(2.0, True), (40.0, False)])
def test_a_part_that_chance_explains_beside_later_ones(monkeypatch, loss, chance):
    monkeypatch.setattr(search, "loss_without", lambda state, rest, part: loss)
    state = SimpleNamespace(bench=SimpleNamespace(y=np.zeros(10_000)))
    part = SimpleNamespace(kind="rate_ramp", role="mean", form="raw")
    assert search.by_chance(state, part, Stand("a")) is chance


# The way of the search: where it ends, and what it may cost.


def ends(*adequate, late=()):
    """Names of the steps that are kept; late: those that the tests in time refute."""

    def step(name, good):
        return SimpleNamespace(name=name, judgement=SimpleNamespace(adequate=good))

    steps = [step(name, good) for name, good in zip("abcde", adequate)]
    with mock.patch.object(search, "judged", lambda one: step(one.name, one.name not in late)):
        return "".join(one.name for one in search.best(steps))


def test_a_search_ends_at_the_last_adequate_step_or_keeps_all():
    assert ends(False, False, True) == "abc"
    assert ends(False, True, False) == "ab"
    assert ends(True, False, False) == "a"
    assert ends(False, True, True, False, late="c") == "ab"
    assert ends(False, False, False) == "abc"
    assert ends(False, True, False, late="b") == "abc"


MODEL = lab_bench.model(n=0.4)


def crowded(lines, samples=20_000, seed=11):
    """White noise and many lines that wander, which bands follow one after the other."""
    rng = np.random.default_rng(seed)
    y = 0.05 * rng.standard_normal(samples)
    for f in np.linspace(1.0, 20.0, lines):
        turn = 2 * np.pi * f * np.arange(samples) / 50
        y += 0.02 * np.sin(turn + np.cumsum(0.05 * rng.standard_normal(samples)))
    return lab_bench.of_gyro(y)


@pytest.fixture(scope="module")
def start():
    with np.errstate(all="ignore"):
        return fitting.start(crowded(12), MODEL)


def forward(start):
    """(search, its steps, fits, transforms): counts, which are the same on every machine."""
    work, steps = start.bench.data.work, []
    before = replace(work)
    start.bench.data.fits.clear()
    with np.errstate(all="ignore"):
        way = search.forward(start, 2, steps.append)
    return way, len(steps), work.fits - before.fits, work.transforms - before.transforms


@pytest.mark.slow
def test_a_crowded_spectrum_is_searched_within_the_bounds(start):
    _, steps, fits, transforms = forward(start)
    assert steps <= SEARCH.steps_most
    assert fits < SEARCH.fits_most
    assert transforms < 1000


@pytest.mark.slow
def test_a_search_ends_with_the_step_that_reaches_the_bound_and_says_so(start, monkeypatch):
    monkeypatch.setattr(search, "SEARCH", replace(SEARCH, fits_most=100))
    way, steps, fits, _ = forward(start)
    assert (steps, way.ended) == (1, "100 fits")
    assert fits >= 100
    monkeypatch.setattr(search, "SEARCH", replace(SEARCH, steps_most=2))
    way, steps, *_ = forward(start)
    assert (steps, way.ended) == (2, "2 steps")


def test_a_search_without_anything_left_did_not_reach_a_bound():
    quiet = lab_bench.of_gyro(0.05 * np.random.default_rng(5).standard_normal(20_000))
    with np.errstate(all="ignore"):
        way = search.forward(fitting.start(quiet, MODEL), 2, lambda text: None)
    assert way.ended == ""
    assert evidence.notes(quiet, MODEL, (), way.ended) == []
    (note,) = evidence.notes(quiet, MODEL, (), "24 steps")
    assert "ended after 24 steps" in note
    assert "may be missing" in note
