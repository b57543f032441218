"""A folder for each property; its examples share it."""

import pytest
from lawful import Work


@pytest.fixture
def work(tmp_path):
    return Work(tmp_path)
