"""The firmware examples: known noise in, the true value within the interval; a power failure at
every byte; a full queue. Each is also compiled for a Cortex-M4F.
"""

import random
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
FLAGS = (
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Werror",
    "-O2",
    "-I",
    ROOT / "lib/include",
)
CORE = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding")


def run(*words):
    done = subprocess.run(
        [str(word) for word in words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert done.returncode == 0, done.stdout


def crc8(data, crc=0xFF):
    """CRC-8/SAE-J1850 from its definition."""
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else crc << 1
    return crc ^ 0xFF


class Firmware(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.linked = Path(cls.folder, "davar.o")
        run(
            "gcc",
            *FLAGS,
            "-I",
            ROOT / "lib/src",
            "-r",
            "-nostdlib",
            *sorted((ROOT / "lib/src").rglob("*.c")),
            "-o",
            cls.linked,
        )

    def program(self, probe, example, *more):
        """A probe of this folder with the sources of an example. more: folders of headers."""
        program, home = Path(self.folder, Path(probe).stem), ROOT / "examples" / example
        if not program.exists():
            places = [word for place in (home, *more) for word in ("-I", place)]
            run(
                "gcc",
                *FLAGS,
                *places,
                HERE / probe,
                *sorted(home.glob("*.c")),
                self.linked,
                "-o",
                program,
                "-lm",
            )
        return program

    def answers(self, program, lines=()):
        done = subprocess.run(
            [program], input="\n".join(map(str, lines)) + "\n", text=True, capture_output=True
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [line.split() for line in done.stdout.splitlines()]

    def test_velocity_random_walk_of_three_axes(self):
        program = self.program("accelerometer_probe.c", "accelerometer")
        # m/s/sqrt(h) of white noise of sigma counts at 200 Hz: sigma 9.80665 / 16384 * sqrt(3600 /
        # 200).
        sigmas = (6.0, 15.0, 40.0)
        held, asked = [0, 0, 0], [0, 0, 0]
        for seed in range(12):
            noise = random.Random(seed)
            lines = [
                " ".join(
                    str(16384 * (axis == 2) + round(noise.gauss(0, sigma)))
                    for axis, sigma in enumerate(sigmas)
                )
                for _ in range(12000)
            ]
            for axis, value, low, high in self.answers(program, lines):
                truth = (sigmas[int(axis)] ** 2 + 1 / 12) ** 0.5 * 9.80665 / 16384 * 18**0.5
                if value != "nan":
                    asked[int(axis)] += 1
                    held[int(axis)] += float(low) <= truth <= float(high)
        self.assertTrue(all(count >= 0.9 * 12 * 59 for count in asked), asked)
        self.assertTrue(
            all(0.91 <= part / count <= 0.985 for part, count in zip(held, asked)), (held, asked)
        )

    def test_the_power_may_fail_at_every_byte_of_a_save(self):
        program = self.program("brown_out_probe.c", "brown_out")
        older, newer = map(int, self.answers(program)[0])
        self.assertGreater(older, 1500)  # number of bytes of an image
        self.assertGreaterEqual(newer, 1)

    def test_a_queue_carries_or_counts_every_sample(self):
        program = self.program("freertos_probe.c", "freertos", HERE / "freertos_stub")
        noise = random.Random(4)
        counts = [round(noise.gauss(0, 30)) for _ in range(40000)]
        *results, told = self.answers(program, counts)
        self.assertEqual(told, ["lost", "0", "gaps", "0"])
        self.assertEqual(len(results), 40000 // 100 - 3)  # windows from 400 samples onward
        truth = (30**2 + 1 / 12) ** 0.5 * 0.05 * 60 / 200**0.5
        known = [tuple(map(float, one)) for one in results if one[0] != "nan"]
        self.assertGreater(sum(low <= truth <= high for _, low, high in known), 0.85 * len(known))
        # The task sleeps through 300 samples, 15 blocks, of which the queue holds 4: 11 are lost,
        # in one gap.
        *results, told = self.answers(program, [*counts[:20000], "lost 300", *counts[20000:]])
        self.assertEqual(told, ["lost", "11", "gaps", "1"])
        self.assertEqual(len(results), (40000 - 220) // 100 - 3)

    def on_the_bus(self, controller, seed):
        """Frames (identifier, data, is_fd) that the controller has sent, its last line."""
        done = subprocess.run(
            [self.program("can_probe.c", "stm32_can"), controller, str(seed)],
            text=True,
            capture_output=True,
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        *lines, told = done.stdout.splitlines()
        frames = [line.removesuffix(" fd").split("#") for line in lines]
        return [
            (int(identifier, 16), bytes.fromhex(data), line.endswith(" fd"))
            for (identifier, data), line in zip(frames, lines)
        ], told.split()

    def check_bus(self, frames, told, a_result):
        """Every frame is intact, in order, and sent once. The sender has counted the losses of the
        bus.
        """
        results, dropped = int(told[1]), 0
        for identifier, data, _ in frames:
            self.assertEqual(crc8(identifier.to_bytes(2, "little") + data[1:]), data[0])
            if identifier == 0x5D5 and data[2] == 6:  # DAVAR_Health, FramesDropped
                dropped = struct.unpack_from("<I", data, 4)[0]
        first = [
            data[1] & 15 for identifier, data, _ in frames if identifier in (0x5D1, 0x5D8)
        ]  # Counter of the first frame of each result
        steps = [(after - before) % 16 for before, after in zip(first, first[1:])]
        self.assertNotIn(0, steps)
        self.assertEqual(sum(steps), results - 1)
        self.assertEqual(len(frames) + dropped, a_result * results)
        self.assertEqual(told[4], "1")  # the bus went off once, and returned
        self.assertGreater(dropped, 0)
        self.assertLess(dropped, 6 * a_result)

    def test_frames_leave_by_the_mailboxes_of_bxcan(self):
        for seed in (1, 2, 3):
            frames, told = self.on_the_bus("bxcan", seed)
            self.check_bus(frames, told, 15)
            self.assertEqual(told[-1], f"{5 | 10 << 16 | 1 << 20:08X}")
            epoch = None
            for identifier, data, _ in frames:
                if identifier == 0x5D1:
                    epoch, tag = struct.unpack_from("<I", data, 4)[0], data[1] & 15
                elif identifier == 0x5D3 and data[1] >> 4 == tag:
                    self.assertEqual(struct.unpack_from("<f", data, 4)[0], epoch + 0.25)

    def test_frames_leave_by_the_fifo_of_fdcan(self):
        for seed in (1, 2, 3):
            frames, told = self.on_the_bus("fdcan", seed)
            self.check_bus(frames, told, 4)
            self.assertEqual(told[-1], f"{1 << 25 | 9 << 16 | 12 << 8 | 1:08X}")
            for identifier, data, is_fd in frames:
                self.assertEqual(is_fd, identifier == 0x5D8)
                self.assertEqual(len(data), 64 if is_fd else 8)
                if is_fd:
                    epoch = int.from_bytes(data[8:11], "little")
                    self.assertEqual(struct.unpack_from("<4f", data, 32), (epoch + 0.25,) * 4)

    def test_they_compile_for_a_microcontroller(self):
        for example in ("accelerometer", "brown_out", "freertos", "stm32_can"):
            for source in sorted((ROOT / "examples" / example).glob("*.c")):
                run(
                    "arm-none-eabi-gcc",
                    *FLAGS,
                    *CORE,
                    "-I",
                    HERE / "freertos_stub",
                    "-c",
                    source,
                    "-o",
                    Path(self.folder, "object.o"),
                )


if __name__ == "__main__":
    unittest.main()
