"""The library of PlatformIO: pio packs it and builds its example, for this machine and for a
Cortex-M4. The program for this machine finds the simulated noise and its change.
"""

import json
import re
import shutil
import tarfile

import pytest
from packaging_tools import HERE, files_below, run

# pio requests the list of licences from the network; only this is replaced.
PIO = (
    "import sys; from platformio.package.manifest.schema import ManifestSchema as schema; "
    "schema.load_spdx_licenses = staticmethod(lambda: {'licenses': [{'licenseId': 'MIT'}]}); "
    "from platformio.__main__ import main; sys.exit(main())"
)
SCONS = "import sys\nsys.path.insert(0, %r)\nfrom SCons.Script import main\nmain()\n"
NATIVE = """from platformio.platform.base import PlatformBase


class NativePlatform(PlatformBase):
    pass
"""
pytestmark = pytest.mark.soak


def install(folder, kind, name, version, **more):
    """What PlatformIO's registry would install: a package with its receipt."""
    folder.mkdir(parents=True)
    (folder / f"{'platform' if kind == 'platform' else 'package'}.json").write_text(
        json.dumps({"name": name, "version": version, **more})
    )
    spec = {"owner": "platformio", "id": None, "name": name, "requirements": None, "uri": None}
    (folder / ".piopm").write_text(
        json.dumps({"type": kind, "name": name, "version": version, "spec": spec})
    )


@pytest.fixture
def pio(tools, draft, tmp_path):
    """pio, with a platform `native` that uses Debian's compilers, and PyPI's scons as the package
    that it builds with.
    """
    core = tmp_path / "core"
    shutil.copytree(draft.layout / "platformio", tmp_path / "davar")
    (site,) = (tools.parent / "lib").glob("python3*/site-packages")
    version = re.fullmatch(r"(?i)scons-([\d.]+)\.dist-info", next(site.glob("[Ss][Cc]*ons-*")).name)
    major, minor, patch = version[1].split(".")
    scons, native = core / "packages/tool-scons", core / "platforms/native"
    install(scons, "tool", "tool-scons", f"4.{major}{int(minor):02}{int(patch):02}.0")
    (scons / "scons.py").write_text(SCONS % str(site))
    install(native, "platform", "native", "1.0.0", title="native", packages={})
    (native / "builder").mkdir()
    (native / "platform.py").write_text(NATIVE)
    shutil.copy(HERE / "platformio_platform.py", native / "builder/main.py")

    def pio(*words, status=0, **variables):
        return run(
            tools / "python",
            "-c",
            PIO,
            *words,
            folder=tmp_path,
            status=status,
            HOME=str(tmp_path),
            PLATFORMIO_CORE_DIR=str(core),
            PLATFORMIO_SETTING_ENABLE_TELEMETRY="no",
            PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL="999999",
            **variables,
        )

    return pio


def test_pio_packs_it(pio, draft, tmp_path):
    pio("pkg", "pack", tmp_path / "davar", "-o", tmp_path / "davar.tar.gz")
    with tarfile.open(tmp_path / "davar.tar.gz") as packed:
        assert files_below(draft.layout / "platformio") <= set(packed.getnames())


def test_the_example_runs_here(pio, tmp_path):
    pio("run", "-d", tmp_path / "davar/examples/arw")
    said = run(tmp_path / "davar/examples/arw/.pio/build/native/program.elf").splitlines()
    (told,) = (float(line.split()[0]) for line in said if "the noise has changed" in line)
    assert 60 < told < 62  # the noise triples at 60 s
    found = (re.match(r" *([\d.]+) s  ARW ([\d.]+) ", line) for line in said)
    for match in found:
        second, value = float(match[1]), float(match[2])
        if 30 < second <= 60 or second > 90:
            assert abs(value / (0.3 if second <= 60 else 0.9) - 1) < 0.1, match[0]


def test_the_example_is_built_for_a_cortex_m4_with_flags_of_the_package(pio, tmp_path):
    example = tmp_path / "davar/examples/arw"
    said = pio("run", "-v", "-d", example, DAVAR_PREFIX="arm-none-eabi-")
    own = [line for line in said.splitlines() if "glr.c" in line and "-c" in line.split()]
    assert own
    assert all("-ffp-contract=off" in line and "-DDAVAR_TAUS_MAX=8" in line for line in own)
    program = example / ".pio/build/native/program.elf"
    assert "Tag_CPU_arch: v7E-M" in run("arm-none-eabi-readelf", "-A", program)
