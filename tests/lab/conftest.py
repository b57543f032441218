import pytest


@pytest.fixture
def lab(tmp_path):
    """A folder with the usual model."""
    from lab_bench import Lab

    return Lab(tmp_path)
