"""Commands that tests/commands runs in another way than as typed, or not at all."""

import re
from typing import NamedTuple

HOURS = "takes hours"
RELEASE = "part library of tools/test runs it"
KERNEL = "tests/kernel/test_readme.py"
PORTING = "tests/target/test_porting.py"
PROOFS = "tests/proofs/test_contracts.py"
TUTORIAL = "tests/lab/test_tutorial.py"
MAKE_TABLE = "tools/davarlab export build/better.toml -o build/gyro_model.csv --window 6000"


class Row(NamedTuple):
    """What differs for the commands that `pattern` matches completely."""

    pattern: str
    elsewhere: str = ""  # the test that runs them, or the reason why none does
    soak: bool = False  # only tools/soak runs them
    before: str = ""  # a preparation that the page describes in text
    replaced: tuple[str, str] = ("", "")  # a word that the reader replaces, and its replacement
    ready: str = ""  # the output after which a program that does not end is interrupted
    status: int = 0  # an exit status other than 0 that is a valid result


ROWS = (
    Row(r"(\w+=\S+ )?(nice )?tools/test\b(?! --list).*", "it would run this test again"),
    Row(r"ctest -R .*|(build/release/tests/)?davar-statistics .*|build/release/tests/.*", RELEASE),
    Row(r"tools/soak|tools/davar-mutants .*|tools/davarlab nulls .*", HOURS),
    Row(r".* tests/workbench/benchmark_page\.py 3", HOURS),
    Row(r".* tests/lab/benchmark_real\.py .*", "needs recordings that are not in the project"),
    Row(r"tools/davar-bench --(targets|setups|csv)\b.*", "measures for many minutes"),
    Row(r"tools/davar-bench --(pages|tracking)", soak=True),
    Row(r"tools/davarlab live can:vcan0.*|ip link .*|candump .*|tools/davar-node .*", KERNEL),
    Row(r"tools/davar-sim .* --out (can|slcan):.*", KERNEL),
    Row(r"kernel=.*|tools/support/uml/run .*", "tests/kernel/test_day.py"),
    Row(r"cp port/bare_metal/.*|tools/davar-mcu --target my-board .*|.*\| cmp - .*", PORTING),
    Row(r"tools/davar-mcu --target cortex-m4f .*", soak=True),
    Row(r"python3 -B tests/proofs/(proving\.py push|contracts\.py slide) .*", PROOFS),
    Row(r"python3 -B tests/proofs/loops\.py", "tests/proofs/test_loops.py"),
    Row(r"time python3 -B tests/proofs/proving\.py NAME", soak=True, replaced=("NAME", "slcan")),
    Row(r".*fuzz-tracked-crash-SHA1", "needs an input that shows a fault"),
    Row(r"cmake --preset fuzz .*|tests/fuzz/corpus\.py merge .*", soak=True),
    Row(r"mkdir -p build/found .*", soak=True, ready="INITED", status=72),  # that of libFuzzer
    Row(r"tools/soak --only .*", soak=True, replaced=("0.01", "0.002")),
    Row(r"tools/davarlab imu .*", status=1),  # a model does not fit
    Row(r"tools/davarlab fleet 'build/fleet/\*\.parquet' .*", "tests/lab/test_fleet.py"),
    Row(r".* data/make_fleet\.py .*|tools/davarlab fleet 'build/fleet/\*_00.*", soak=True),
    Row(r"pip install .*|python -m build", "tests/package/conftest.py"),
    Row(r"python examples/ahrs_flight/flight\.py", "tests/package/test_ahrs_flight.py"),
    Row(r"python examples/strapdown/strapdown\.py", "tests/package/test_strapdown.py"),
    Row(
        r"cmake -S examples/kalman_flight .*|build/flight/flight .*",
        "tests/examples/test_kalman_flight.py",
    ),
    Row(r"tools/davarlab (fit|diagnose|improve) +build/rec\.csv .*", TUTORIAL),
    Row(r"tools/davarlab open", ready=r"http://127\.0\.0\.1:\d+/\?token="),
    Row(r"tools/davarlab (import|fit) LOG --sensor .*", replaced=("NAME", "sensor_gyro:0")),
    Row(r"tools/davar-sim .* --model-table build/gyro_model\.csv", before=MAKE_TABLE),
    Row(r"cmake -S davar -B b .*", "tests/consumer/test_install.py"),
    Row(r"cmake -S \. .*|cmake --install .*|conan .*|tools/release .*", soak=True),
    Row(r"pio (run|pkg pack)", "tests/packages/test_platformio.py"),
    Row(r"dpkg -i .*", "tests/packages/test_debian.py"),
    Row(r"(idf\.py|cpackget|vcpkg) .*", "the tool is in no package of Debian or PyPI"),
    Row(r"python3 tests/betaflight/firmware\.py image", "fetches from the network"),
    Row(r"mkdir -p build/davar|\(cd build/davar .*|arm-none-eabi-gcc(-ar)? .*", soak=True),
)


def row_of(text):
    """The row of a command, or one that changes nothing."""
    found = [row for row in ROWS if re.fullmatch(row.pattern, text)]
    assert len(found) < 2, f"{text}: two rows"
    return found[0] if found else Row("")
