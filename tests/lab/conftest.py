import pytest


@pytest.fixture
def lab(tmp_path):
    """A folder with the usual model."""
    from lab_bench import Lab

    return Lab(tmp_path)


@pytest.fixture
def logs(tmp_path):
    """A folder with the log of a known gyro."""
    from reading_logs import Logs

    return Logs(tmp_path)
