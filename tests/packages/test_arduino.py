"""The library of Arduino: arduino-builder finds it by <davar.h> and builds its sketches for a
Cortex-M4 and for this machine. Here the sketches read simulated sensors (written from the data
sheets) through their registers.
"""

import re
import shutil

import pytest
from packaging_tools import HERE, run

# Sketch: its sensor, and how long the processor may be busy, in seconds: one has a FIFO of five.
SKETCHES = {"ArwMpu6050": ("mpu6050", "4", "7"), "ArwLsm6ds": ("lsm6ds", "0", "1")}


@pytest.fixture(scope="module")
def built(draft, tmp_path_factory):
    """Builds a sketch: returns the program, or the output if it must fail."""
    work, made = tmp_path_factory.mktemp("arduino"), {}
    shutil.copytree(draft.layout / "arduino", work / "libraries/davar")

    def built(sketch, board, status=0):
        there = work / board / sketch
        if there in made:
            return made[there]
        there.mkdir(parents=True)
        words = ["arduino-builder", "-compile", "-warnings", "all", "-hardware", HERE / "arduino"]
        words += ["-hardware", "/usr/share/arduino-builder", "-tools", "/usr/bin"]
        words += ["-libraries", work / "libraries", "-fqbn", f"davar:samd:{board}"]
        source = work / f"libraries/davar/examples/{sketch}/{sketch}.ino"
        said = run(*words, "-build-path", there, source, status=status)
        made[there] = said if status else there / f"{sketch}.ino.elf"
        return made[there]

    return built


def rows(program, *words):
    """The rows of a sketch."""
    title, *lines = run(program, *words).splitlines()
    assert title == "window_samples,arw_deg_per_sqrt_h,arw_low,arw_high,gaps"
    return [list(map(float, line.split(","))) for line in lines]


@pytest.mark.parametrize("sketch", SKETCHES)
def test_the_sketches_report_the_noise_of_the_sensor(built, sketch):
    program, (sensor, short, long) = built(sketch, "host"), SKETCHES[sketch]
    found = rows(program, sensor, "60")
    assert len(found) >= 53  # one per second, from the sixth onward
    for window, value, low, high, gaps in found:
        assert window in (600, 624) and gaps == 0
        assert abs(value - 0.3) < 0.06  # four standard deviations for such a window
        assert low < value < high
    covered = sum(low <= 0.3 <= high for _, _, low, high, _ in found) / len(found)
    assert covered > 0.6  # 95 % on average; neighbours share five sixths of their samples
    # Samples lost while the processor was busy are a gap.
    assert rows(program, sensor, "40", "12", short)[-1][4] == 0
    assert rows(program, sensor, "40", "12", long)[-1][4] == 1
    said = run(program, "none", "3")
    assert re.fullmatch(r"(no (MPU-6050|LSM6DS) at 0x6\w.*\n)+", said)


@pytest.mark.soak
def test_a_board_whose_double_has_32_bits_is_rejected(built):
    assert "davar needs a double of 64 bits" in built("ArwMpu6050", "avr", status=1)


@pytest.mark.soak
@pytest.mark.parametrize("sketch", SKETCHES)
def test_they_are_built_for_a_cortex_m4(built, sketch):
    program = built(sketch, "m4")
    assert "Tag_CPU_arch: v7E-M" in run("arm-none-eabi-readelf", "-A", program)


def test_the_properties_list_architectures_and_an_existing_header(draft):
    folder = draft.layout / "arduino"
    text = (folder / "library.properties").read_text()
    values = dict(re.findall(r"^(\w+)=(.+)$", text, re.MULTILINE))
    architectures = values["architectures"].split(",")
    assert not {"*", "avr", "megaavr"} & set(architectures)
    assert "samd" in architectures
    assert (folder / "src" / values["includes"]).is_file()
