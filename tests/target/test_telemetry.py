"""The flash that an encoder of davar/telemetry.h takes on each Arm core, alone in a program: its
functions and tables, without those of the C library and the compiler.
"""

import subprocess

import c_library
import pytest
from on_boards import boards
from targets import ROOT

REAL = ROOT / "lib/src/number/real.c"
FLASH_MAX = 1536
CORES = {
    "cortex-m0": "-mcpu=cortex-m0",
    "cortex-m3": "-mcpu=cortex-m3",
    "cortex-m4f": "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16",
    "cortex-m7": "-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16",
    "cortex-m33": "-mcpu=cortex-m33 -mfloat-abi=hard -mfpu=fpv5-sp-d16",
}
DIALECTS = ("davar_mavlink", "davar_mavlink_gyro_noise", "davar_dronecan", "davar_cyphal")
USER = """#include "davar/telemetry.h"
static davar_telemetry_t telemetry;
static const davar_telemetry_address_t from = {0, 1, 1, 1};
davar_packet_t packet;
davar_result_t result;
void _start(void)
{
    if (!davar_telemetry_init(&telemetry, &%s, &from, 100.0)) {
        return;
    }
    davar_telemetry_begin(&telemetry, &result, NULL, 1U);
    while (davar_telemetry_next(&telemetry, &packet)) {
    }
    (void)davar_telemetry_heartbeat(&telemetry, 1U, &packet);
}
"""


def run(folder, *command):
    words = [str(word) for word in command]
    return subprocess.run(words, text=True, capture_output=True, check=True, cwd=folder).stdout


@pytest.mark.parametrize("core", boards(CORES))
def test_each_dialect_takes_at_most_one_and_a_half_kilobytes(core, tmp_path):
    compiler = ["arm-none-eabi-gcc", "-mthumb", *CORES[core].split(), "-std=c11", "-Os", "-DNDEBUG"]
    compiler += ["-ffunction-sections", "-fdata-sections"]
    compiler += c_library.FLAGS
    sources = [*sorted((ROOT / "addons/telemetry/src").glob("*.c")), REAL]
    run(tmp_path, *compiler, "-c", *sources)
    objects = [f"{source.stem}.o" for source in sources]
    listed = [line.split() for line in run(tmp_path, "arm-none-eabi-nm", *objects).splitlines()]
    names = {word[2] for word in listed if len(word) == 3}  # two words: not defined here
    linking = ["-Wl,--gc-sections,--no-warnings", "-nostartfiles", "--specs=nosys.specs"]
    for dialect in DIALECTS:
        (tmp_path / "user.c").write_text(USER % dialect)
        run(tmp_path, *compiler, *linking, "user.c", *objects, "-lm", "-o", "program.elf")
        symbols = run(tmp_path, "arm-none-eabi-nm", "-S", "program.elf").splitlines()
        words = [line.split() for line in symbols if len(line.split()) == 4]
        size = sum(int(w[1], 16) for w in words if w[3] in names and w[2] in "tTrRdD")
        assert 300 < size <= FLASH_MAX, dialect
