"""The firmware examples: known noise in, the true value within the interval; a power failure at
every byte; a full queue. Each is also compiled for a Cortex-M4F.
"""

import random
import struct
import subprocess
from pathlib import Path

import c_library
import pytest

ROOT, HERE = Path(__file__).resolve().parents[2], Path(__file__).resolve().parent
STUB = HERE / "freertos_stub"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
FLAGS = ("-std=c11", *WARNINGS, "-O2", *c_library.PROGRAM_FLAGS)
CORE = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding")

pytestmark = pytest.mark.slow


def run(*words):
    done = subprocess.run([str(word) for word in words], text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr


def crc8(data, crc=0xFF):
    """CRC-8/SAE-J1850 from its definition."""
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else crc << 1
    return crc ^ 0xFF


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """Compiles a probe of this folder with the sources of an example."""
    folder = tmp_path_factory.mktemp("examples")
    lib = ("-I", ROOT / "lib/src", "-r", "-nostdlib", *c_library.SOURCES)
    run("gcc", *FLAGS, *lib, "-o", folder / "davar.o")

    def program(probe, example):
        found, home = folder / Path(probe).stem, ROOT / "examples" / example
        if not found.exists():
            places = ("-I", home, "-I", STUB, HERE / probe, *sorted(home.glob("*.c")))
            run("gcc", *FLAGS, *places, folder / "davar.o", "-o", found, "-lm")
        return found

    program.folder = folder
    return program


def answers(program, *words, lines=()):
    text = "\n".join(map(str, lines)) + "\n"
    done = subprocess.run([program, *words], input=text, text=True, capture_output=True)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def test_velocity_random_walk_of_three_axes(build):
    """m/s/sqrt(h) of white noise of sigma counts at 200 Hz: sigma 9.80665 / 16384 * sqrt(3600 /
    200).
    """
    program = build("accelerometer_probe.c", "accelerometer")
    sigmas, gravity = (6.0, 15.0, 40.0), (0, 0, 16384)
    held, given = [0, 0, 0], [0, 0, 0]
    for seed in range(12):
        noise = random.Random(seed)
        samples = [
            [g + round(noise.gauss(0, sigma)) for g, sigma in zip(gravity, sigmas)]
            for _ in range(12000)
        ]
        for line in answers(program, lines=(" ".join(map(str, one)) for one in samples)):
            axis, value, low, high = line.split()
            truth = (sigmas[int(axis)] ** 2 + 1 / 12) ** 0.5 * 9.80665 / 16384 * 18**0.5
            if value != "nan":
                given[int(axis)] += 1
                held[int(axis)] += float(low) <= truth <= float(high)
    assert all(count >= 0.9 * 12 * 59 for count in given), given
    assert all(0.91 <= part / count <= 0.985 for part, count in zip(held, given)), (held, given)


def test_the_power_may_fail_at_every_byte_of_a_save(build):
    older, newer = map(int, answers(build("brown_out_probe.c", "brown_out"))[0].split())
    assert older > 1500  # number of bytes of an image
    assert newer >= 1


def test_a_queue_carries_or_counts_every_sample(build):
    program, noise = build("freertos_probe.c", "freertos"), random.Random(4)
    counts = [round(noise.gauss(0, 30)) for _ in range(40000)]
    *results, told = answers(program, lines=counts)
    assert told == "lost 0 gaps 0"
    assert len(results) == 40000 // 100 - 3  # windows from 400 samples onward
    truth = (30**2 + 1 / 12) ** 0.5 * 0.05 * 60 / 200**0.5
    known = [tuple(map(float, one.split())) for one in results if not one.startswith("nan")]
    assert sum(low <= truth <= high for _, low, high in known) > 0.85 * len(known)
    # The task sleeps through 300 samples, 15 blocks, of which the queue holds 4: 11 are lost, in
    # one gap.
    *results, told = answers(program, lines=[*counts[:20000], "lost 300", *counts[20000:]])
    assert told == "lost 11 gaps 1"
    assert len(results) == (40000 - 220) // 100 - 3


# Of a controller: frames of a result, and the register of its bit timing.
TIMING = {"bxcan": 5 | 10 << 16 | 1 << 20, "fdcan": 1 << 25 | 9 << 16 | 12 << 8 | 1}
A_RESULT = {"bxcan": 15, "fdcan": 4}


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("controller", TIMING)
def test_frames_leave_by_the_controller(build, controller, seed):
    """Every frame is intact, in order, and sent once. The sender has counted the losses of the
    bus.
    """
    *lines, told = answers(build("can_probe.c", "stm32_can"), controller, str(seed))
    told, a_result, frames = told.split(), A_RESULT[controller], []
    for line in lines:
        identifier, data = line.removesuffix(" fd").split("#")
        frames.append((int(identifier, 16), bytes.fromhex(data)))
        is_fd = frames[-1][0] == 0x5D8
        assert (line.endswith(" fd"), len(frames[-1][1])) == (is_fd, 64 if is_fd else 8)
    results, dropped, epoch, tag = int(told[1]), 0, None, None
    for identifier, data in frames:
        assert crc8(identifier.to_bytes(2, "little") + data[1:]) == data[0]
        if identifier == 0x5D5 and data[2] == 6:  # DAVAR_Health, FramesDropped
            dropped = struct.unpack_from("<I", data, 4)[0]
        elif identifier == 0x5D1:
            epoch, tag = struct.unpack_from("<I", data, 4)[0], data[1] & 15
        elif identifier == 0x5D3 and data[1] >> 4 == tag:
            assert struct.unpack_from("<f", data, 4)[0] == epoch + 0.25
        elif identifier == 0x5D8:
            epoch = int.from_bytes(data[8:11], "little")
            assert struct.unpack_from("<4f", data, 32) == (epoch + 0.25,) * 4
    # Counter of the first frame of each result
    first = [data[1] & 15 for identifier, data in frames if identifier in (0x5D1, 0x5D8)]
    steps = [(after - before) % 16 for before, after in zip(first, first[1:])]
    assert 0 not in steps
    assert sum(steps) == results - 1
    assert len(frames) + dropped == a_result * results
    assert 0 < dropped < 6 * a_result
    # the bus went off once, and returned
    assert (told[4], told[-1]) == ("1", f"{TIMING[controller]:08X}")


@pytest.mark.parametrize("example", ["accelerometer", "brown_out", "freertos", "stm32_can"])
def test_they_compile_for_a_microcontroller(build, example):
    for source in sorted((ROOT / "examples" / example).glob("*.c")):
        words = (*FLAGS, *CORE, "-I", STUB, "-c", source, "-o", build.folder / "object.o")
        run("arm-none-eabi-gcc", *words)
