"""Commands that tests/commands cannot run as typed, and the requirements of the others.
test_commands.py fails if an entry is no longer in a page.
"""

import re

# Not run: it would run this test again, or another part of the tests.
TESTS = re.compile(r"(\w+=\S+ )?(nice )?tools/test\b(?! --(list|help))|ctest -R \S+( -V)?$")

BUS = "needs a CAN bus; tests/kernel runs such commands on a kernel that has one"
HOURS = "takes hours"
NETWORK = "fetches from the network"
PROVED = "takes two minutes; tests/proofs runs it"

# The exact text: the reason.
NOT_RUN = {
    "python3 tests/betaflight/firmware.py image": NETWORK,
    "tools/davarlab live can:vcan0": BUS,
    "tools/davarlab live can:vcan0 --raw build/raw.csv": BUS,
    "ip link set can0 up type can bitrate 500000 restart-ms 100": "needs a CAN controller",
    "tools/davar-bench --targets": (
        "the same measurement as in tools/davar-bench --json, which runs here"
    ),
    "tools/davar-bench --targets --write": (
        "the same measurement as in tools/davar-bench --json, which runs here; the board of the "
        "page is not available"
    ),
    "tools/davar-bench --setups": "it measures for 20 minutes",
    "tools/davar-bench --csv 100000000": "it takes ten minutes",
    "tools/soak": HOURS,
    "tools/davar-mutants --sample 210": HOURS,
    "tools/davar-mutants --all": HOURS,
    "python3 -B tests/proofs/proving.py push -DPUSHES=24U": (
        "takes many minutes; tests/proofs runs it with narrower bounds"
    ),
    "python3 -B tests/proofs/contracts.py slide -DWIDE=0": PROVED,
    "python3 -B tests/proofs/contracts.py slide -DWIDE=1": PROVED,
    "build/fuzz/tests/fuzz/fuzz_stream build/log/fuzz-stream-crash-SHA1": (
        "needs an input that shows a fault"
    ),
    "tests/fuzz/corpus.py add stream build/log/fuzz-stream-crash-SHA1": (
        "needs an input that shows a fault"
    ),
    "kernel=$(tools/support/uml/kernel.sh ~/.cache/davar/uml)": (
        "builds a Linux kernel; tests/kernel uses it"
    ),
    'tools/support/uml/run -T -t 5400 "$kernel" env DAVAR_DAY_HZ=1 '
    "DAVAR_SIM=$PWD/build/release/host_sim/davar-sim "
    "DAVAR_NODE=$PWD/build/release/gateway/davar-node build/venv-wire/bin/python -B "
    "tests/kernel/test_day.py": "takes an hour; tests/kernel runs a shorter day",
    (
        "tools/davarlab fleet 'build/fleet/*.parquet' -m data/fleet_model.toml -o build/fleet-out "
        "--batch '([AB])_\\d+' --limits data/fleet_limits.toml"
    ): (
        "500 recordings take minutes; tests/lab/test_fleet.py runs the same with 48, and the next "
        "command of the page runs here"
    ),
    'pip install ".[lab]"': (
        "installs a hundred packages; tests/package runs the wheel beside the same pins"
    ),
    "python examples/ahrs_flight/flight.py": (
        "takes half an hour; tests/package/test_ahrs_flight.py flies three of its flights"
    ),
    "pip install . -r examples/ahrs_flight/requirements.txt": (
        "tests/package installs the same packages"
    ),
    "tests/lab/benchmark_awkward.py 41 1": HOURS,
    "tests/lab/benchmark_elsewhere.py 40 1": HOURS,
    "build/venv-browser/bin/python tests/workbench/benchmark_page.py 3": (
        "times a browser, which needs a machine that does nothing else"
    ),
    "tools/davarlab nulls --recordings 100 --first-seed 1000": HOURS,
    "tools/davarlab nulls --recordings 100 --first-seed 2000 --adequacy-only": HOURS,
    "build/venv-lab/bin/python tests/lab/benchmark_real.py [--axis NAME] [--out TABLE.md]": (
        "needs recordings that are not in the project"
    ),
    "build/release/tests/test_closed": "part release of tools/test runs it",
    "build/release/tests/test_closed long": (
        "three minutes; part release of tools/test checks the smaller windows"
    ),
    "build/release/tests/test_steady 100 7": (
        "minutes of statistics; part release of tools/test runs an eighth of it"
    ),
    "build/release/tests/test_selected 10": (
        "minutes of statistics; part release of tools/test flies a tenth of them"
    ),
    "build/release/tests/davar-track-terms 20": (
        "minutes of statistics; part release of tools/test runs its check"
    ),
    "dpkg -i libdavar-dev_V_amd64.deb": (
        "changes this machine's packages; tests/packages/test_debian.py installs it "
        "into a root of its own"
    ),
    "idf.py menuconfig": "needs ESP-IDF",
    "cpackget add": "needs the tools of Open-CMSIS-Pack",
    "vcpkg install davar --overlay-ports=FOLDER": (
        "needs vcpkg; tests/packages/test_vcpkg.py runs the port"
    ),
}

# The exact text: the test that runs it unchanged.
RUN_BY = {
    (
        "cmake -S davar -B b -DDAVAR_BUILD_TESTS=OFF -DDAVAR_BUILD_SIM=OFF && cmake --build b && "
        "cmake --install b --prefix P"
    ): "tests/consumer/test_install.py",
    "cp port/bare_metal/mps2.c port/bare_metal/my_board.c": "tests/target/test_porting.py",
    (
        "tools/davar-mcu --target my-board data/demo_disturbance.csv.gz --lsb 0.001 "
        "--stride 100 >device.csv"
    ): "tests/target/test_porting.py",
    "tools/davar-sim data/demo_disturbance.csv.gz --lsb 0.001 --stride 100 | cmp - device.csv": (
        "tests/target/test_porting.py"
    ),
    "ip link add vcan0 type vcan && ip link set vcan0 up": "tests/kernel/test_readme.py",
    "candump vcan0 | cantools decode tools/davar.dbc": "tests/kernel/test_readme.py",
    "tools/davarlab live can:vcan0 --record build/arw.csv": "tests/kernel/test_readme.py",
    (
        "tools/davar-sim data/demo_disturbance.csv.gz --lsb 0.001 --stride 100 --pace "
        "100 --out can:vcan0"
    ): "tests/kernel/test_readme.py",
    "tools/davar-node --source value:/sys/bus/iio/devices/iio:device0/in_anglvel_z_raw --rate 100 "
    "--lsb 0.0076 --edges gpiochip0:17 "
    "--alarm gpiochip0:27 --channel 1 --out can:vcan0": "tests/kernel/test_readme.py",
    (
        "tools/davar-sim data/demo_disturbance.csv.gz --lsb 0.001 --stride 100 --pace 100 --out "
        "slcan:/dev/ttyUSB0"
    ): "tests/kernel/test_readme.py",
    "python -m build": "tools/support/python_suites.py",
    "pio pkg pack": "tests/packages/test_platformio.py",
    "pio run": "tests/packages/test_platformio.py",
    "compote component pack": "tests/packages/test_esp_idf.py",
}

# Programs that run until they are stopped: their output when they are ready, and how to stop them.
UNTIL_STOPPED = {
    "tools/davarlab open": (r"http://127\.0\.0\.1:\d+/\?token=", "SIGINT"),
    (
        "mkdir -p build/found && build/fuzz/tests/fuzz/fuzz_stream -max_len=400 build/found "
        "$(tests/fuzz/corpus.py unpack stream)"
    ): (r"INITED", "SIGINT"),
}

# A word that a reader replaces: its replacement here. A placeholder for a file becomes a file
# (test_commands.py, furnish).
REPLACED = {
    "tools/davarlab import LOG --sensor NAME -o REC.csv": {"NAME": "sensor_gyro:0"},
    "tools/davarlab fit LOG --sensor NAME -m MODEL.toml --axes all -o model.toml": {
        "NAME": "sensor_gyro:0"
    },
    "time python3 -B tests/proofs/proving.py NAME": {"NAME": "slcan"},
    "tools/soak --only fuzz-calls,tabs --share 0.01": {"0.01": "0.002"},
}

# Exit statuses other than 0 that are valid results.
STATUS = {
    # the status of libFuzzer after an interrupt
    (
        "mkdir -p build/found && build/fuzz/tests/fuzz/fuzz_stream -max_len=400 build/found "
        "$(tests/fuzz/corpus.py unpack stream)"
    ): 72,
}

# Preparations that a page describes in text.
BEFORE = {
    (
        "tools/davar-sim build/rec.csv --window-max 6000 --stride 6000 --policy fixed --mode "
        "trailing --model-table build/gyro_model.csv"
    ): "tools/davarlab export build/better.toml -o build/gyro_model.csv --window 6000",
    "tools/davarlab fit build/counter.csv --clock freq_hz=10e6 -o build/clock.toml": (
        'awk \'BEGIN { srand(1); print "time_s,freq_hz"; for (i = 0; i < 3000; i++) '
        'printf "%d,%.7f\\n", i, 1e7 + 0.001 * (rand() + rand() + rand()) }\' '
        ">build/counter.csv"
    ),
    "tools/davarlab fit build/phase.txt --names phase_s --rate 1 -o build/clock.toml": (
        "awk 'BEGIN { srand(2); for (i = 0; i < 3000; i++) "
        'printf "%.12f\\n", 1e-9 * (rand() + rand() + rand()) }\' >build/phase.txt'
    ),
}
