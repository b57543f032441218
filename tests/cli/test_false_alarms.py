"""How often the window law reports plain white noise as unstable: the figures of FIRMWARE.md."""

import pytest
from sim_case import recording, sim

RATE = "--unstable-rate 0.01"
LENGTHS = [
    f"{RATE} --policy or --window-max {n} --window-min {n} --segment 100" for n in (300, 600, 2000)
]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return recording(tmp_path_factory.mktemp("white"), count=100_000)


@pytest.mark.parametrize(
    ("words", "low", "high"),
    [
        ("", 0.15, 0.23),  # the bounds of the paper are wrong for one window in five
        ("--policy and", 0.015, 0.045),
        ("--kurtosis 2:4 --contribution 0:0.2", 0.0, 0.01),
        (RATE, 0.0, 0.012),
        *((words, 0.0, 0.02) for words in LENGTHS),  # 50 to 350 independent windows
    ],
)
def test_the_share_of_unstable_windows(path, words, low, high):
    lines = sim(path, "--lsb", "0.01", *words.split()).stdout.splitlines()
    unstable = [line.split(",", 6)[5] for line in lines]
    assert unstable.pop(0) == "unstable"
    assert low <= unstable.count("1") / len(unstable) <= high
