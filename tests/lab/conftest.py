"""Fixtures of the lab's tests. A scenario is made and analysed once a session."""

import functools

import pytest


@pytest.fixture
def lab(tmp_path):
    """A folder with the usual model."""
    from lab_bench import Lab

    return Lab(tmp_path)


@pytest.fixture(scope="session")
def analysed():
    from lab_scenarios import SCENARIOS, Analysed

    return functools.cache(lambda name: Analysed(SCENARIOS[name]))
