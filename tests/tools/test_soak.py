"""tools/soak: slices, resuming and the table, with short checks of its own."""

import re

import pytest
import soak


@pytest.fixture
def soaked(tmp_path, monkeypatch, capsys):
    """A function that runs checks: (exit status, printed text)."""

    def run(checks, stop_after=None):
        monkeypatch.setattr(soak, "CHECKS", checks)
        one = soak.Soak(list(checks), 1.0, tmp_path)
        if stop_after:
            save = one.save
            one.save = lambda: (save(), len(run.slices) >= stop_after and one.stopped.set())
        return one.run(), capsys.readouterr().out

    def check(name, hours, whole=False):
        """A check that records its slices."""

        def recorded(length, number, folder):
            run.slices.append((name, round(length, 3), number))
            return soak.Done(length, counts={"runs": 1000, "most edges": 10 - number}, found=[])

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
