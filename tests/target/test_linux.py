"""davar-sim on the boards with Linux: the same bytes as on this machine, both results and error
messages. DAVAR_SIM: this machine's davar-sim.
"""

import gzip
import os
import subprocess
from functools import cache

import pytest
import targets

pytestmark = pytest.mark.soak

ROOT = targets.ROOT
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
# Options, exit status.
JOBS = (
    ("--lsb 0.001 --stride 100", 0),
    ("--lsb 0.001 --stride 50 --out jsonl --details", 0),
    ("--lsb 0.002 --mode trailing --taus 1,2,4,8,16", 0),
    ("--arith float --stride 70", 0),
    ("--window-max 0", 2),
    ("--law guess", 2),
    ("--lsb -1", 2),
    ("--column absent", 2),
)


@cache
def built(target):
    """The board's davar-sim. Debian has no zlib for all such machines, so recordings are plain text
    there.
    """
    where = targets.folder(target, "sim")
    compiler = targets.MACHINES[target]["toolchain"] + "gcc"
    library = targets.run([compiler, "-print-file-name=libm.a"], f"libm.a of {target}").strip()
    settings = {
        "CMAKE_TOOLCHAIN_FILE": ROOT / "port/bare_metal/targets/linux.cmake",
        "DAVAR_TARGET": target,
        "CMAKE_BUILD_TYPE": "Release",
        "DAVAR_WERROR": "ON",
        "DAVAR_BUILD_SIM": "ON",
        "ZLIB_INCLUDE_DIR": ROOT / "tests/target/without_zlib",
        "ZLIB_LIBRARY": library,  # any: no function of zlib is called
    }
    options = [f"-D{name}={value}" for name, value in settings.items()]
    targets.run(["cmake", "-S", ROOT, "-B", where, *options], f"configuring {target}")
    jobs = str(os.cpu_count() or 2)
    make = ["cmake", "--build", where, "--target", "davar-sim", "--parallel", jobs]
    targets.run(make, f"building {target}")
    return where / "host_sim/davar-sim"


def ran(command):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "demo.csv"
    path.write_bytes(gzip.decompress((ROOT / "data/demo_disturbance.csv.gz").read_bytes()))
    return path


@pytest.mark.parametrize("options, status", JOBS)
@pytest.mark.parametrize("target", [name for name in targets.MACHINES if name not in targets.BARE])
def test_the_same_bytes_as_here(target, options, status, recording):
    words = [str(recording), *options.split()]
    here = ran([SIM, *words])
    assert here[0] == status, here[2]
    assert status or here[1].count(b"\n") > 50
    there = ran([*targets.command(target, built(target)), *words])
    assert here == there
