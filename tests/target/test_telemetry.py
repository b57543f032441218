"""The flash that an encoder of davar/telemetry.h takes on each Arm core, alone in a program: its
functions and tables, without those of the C library and the compiler.
"""

import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REAL = ROOT / "lib/src/number/real.c"
FLASH_MAX = 1536
CORES = {
    "cortex-m0": ["-mcpu=cortex-m0"],
    "cortex-m3": ["-mcpu=cortex-m3"],
    "cortex-m4f": ["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    "cortex-m7": ["-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16"],
    "cortex-m33": ["-mcpu=cortex-m33", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"],
}
DIALECTS = ("davar_mavlink", "davar_mavlink_gyro_noise", "davar_dronecan", "davar_cyphal")
USER = """#include "davar/telemetry.h"
static davar_telemetry_t telemetry;
static const davar_telemetry_address_t from = {0, 1, 1, 1};
davar_packet_t packet;
davar_result_t result;
void _start(void)
{
    (void)davar_telemetry_init(&telemetry, &%s, &from, 100.0);
    davar_telemetry_begin(&telemetry, &result, 1U);
    while (davar_telemetry_next(&telemetry, &packet)) {
    }
    (void)davar_telemetry_heartbeat(&telemetry, 1U, &packet);
}
"""


def run(*command):
    done = subprocess.run([str(word) for word in command], text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


class Flash(unittest.TestCase):
    def sizes(self, work, flags):
        """Bytes of davar's symbols in a linked program, by dialect."""
        compiler = ["arm-none-eabi-gcc", "-mthumb", *flags, "-std=c11", "-Os", "-DNDEBUG"]
        compiler += ["-ffunction-sections", "-fdata-sections", f"-I{ROOT / 'lib/include'}"]
        compiler += [f"-I{ROOT / 'lib/src'}"]
        objects = []
        for source in [*sorted((ROOT / "lib/src/wire").glob("*.c")), REAL]:
            objects.append(work / f"{source.stem}.o")
            run(*compiler, "-c", source, "-o", objects[-1])
        listed = [line.split() for line in run("arm-none-eabi-nm", *objects).splitlines()]
        names = {word[2] for word in listed if len(word) == 3}  # two words: not defined here
        found = {}
        for dialect in DIALECTS:
            user, program = work / "user.c", work / "program.elf"
            user.write_text(USER % dialect)
            linking = ["-Wl,--gc-sections,--no-warnings", "-nostartfiles", "--specs=nosys.specs"]
            run(*compiler, *linking, user, *objects, "-lm", "-o", program)
            symbols = [one.split() for one in run("arm-none-eabi-nm", "-S", program).splitlines()]
            found[dialect] = sum(
                int(word[1], 16)
                for word in symbols
                if len(word) == 4 and word[3] in names and word[2] in "tTrRdD"
            )
        return found

    def test_each_dialect_takes_at_most_one_and_a_half_kilobytes(self):
        for core, flags in CORES.items():
            with tempfile.TemporaryDirectory() as folder:
                sizes = self.sizes(Path(folder), flags)
            print(core, sizes, flush=True)
            for dialect, size in sizes.items():
                with self.subTest(core=core, dialect=dialect):
                    self.assertGreater(size, 300)
                    self.assertLessEqual(size, FLASH_MAX)


if __name__ == "__main__":
    unittest.main()
