"""tools/soak: slices, resuming, faults and the table, with short checks of its own."""

import re
import subprocess
import sys

import pytest
import soak


@pytest.fixture
def soaked(tmp_path, monkeypatch, capsys):
    """A function that runs checks: (exit status, printed text)."""

    def run(checks, folder="commit", stop_after=None):
        monkeypatch.setattr(soak, "CHECKS", checks)
        one = soak.Soak(list(checks), 1.0, tmp_path / folder)
        if stop_after:
            save = one.save
            one.save = lambda: (save(), len(run.slices) >= stop_after and one.stopped.set())
        return one.run(), capsys.readouterr().out

    def check(name, hours, whole=False, fault=None):
        """A check that records its slices; the slice with the number `fault` finds something."""

        def recorded(length, number, folder):
            run.slices.append((name, round(length, 3), number))
            found = ["input-1"] if number == fault else []
            return soak.Done(length, counts={"runs": 1000, "most edges": 10 - number}, found=found)

        return soak.Check(hours, recorded, ("fuzz",), whole)

    run.slices, run.check = [], check
    return run


def test_slices_add_up_and_a_check_of_one_slice_has_one(soaked):
    status, said = soaked({"a": soaked.check("a", 0.2), "b": soaked.check("b", 7, whole=True)})
    assert status == 0
    of_a = [one[1:] for one in soaked.slices if one[0] == "a"]
    assert of_a == [(0.083, 0), (0.083, 1), (0.033, 2)]
    assert ("b", 7, 0) in soaked.slices
    row = next(line for line in said.splitlines() if line.startswith("a "))
    assert re.fullmatch(r"a +0:12 of 0:12  3 000 runs, 10 edges +nothing", row)


def test_an_interrupted_run_continues(soaked):
    status, said = soaked({"a": soaked.check("a", 0.3)}, stop_after=2)
    assert (status, "0:10 of 0:18" in said, "continues" in said) == (130, True, True)
    assert soaked({"a": soaked.check("a", 0.3)})[0] == 0
    assert [number for *_, number in soaked.slices] == [0, 1, 2, 3]


@pytest.mark.slow
def test_a_check_that_has_found_something_stops_for_good(soaked):
    checks = {"a": soaked.check("a", 1, fault=1), "b": soaked.check("b", 0.1)}
    status, said = soaked(checks)
    assert status == 1
    assert re.search(r"a +0:10 of 1:00 .* input-1", said)
    assert re.search(r"b +0:06 of 0:06 .* nothing", said)
    assert "(nothing was found on any earlier commit)" in said
    count = len(soaked.slices)
    assert (soaked(checks)[0], len(soaked.slices)) == (1, count)


@pytest.mark.slow
def test_the_last_commit_without_a_finding_is_named(soaked):
    assert soaked({"a": soaked.check("a", 0.1)})[0] == 0
    status, said = soaked({"a": soaked.check("a", 0.1, fault=0)}, "later")
    assert (status, "(nothing was found on commit)" in said) == (1, True)


@pytest.mark.slow
def test_a_check_that_cannot_run_and_a_wrong_option_are_one_line(soaked):
    def broken(*_):
        raise soak.Broken("lines\nno compiler")

    status, said = soaked({"a": soak.Check(1, broken, ("fuzz",))})
    assert (status, "cannot run: no compiler" in said) == (1, True), said
    for words, name in ((["--only", "fuzz-x"], "fuzz-x"), (["--share", "0"], "--share 0")):
        command = [sys.executable, soak.__file__, *words]
        done = subprocess.run(command, text=True, capture_output=True)
        assert (done.returncode, name in done.stderr.splitlines()[-1]) == (2, True)
