"""The library of PlatformIO: pio packs it and rejects wrong manifests. pio builds the example of
the package, for this machine and for a Cortex-M4. The program for this machine finds the simulated
noise and its change.
"""

import importlib.metadata
import json
import re
import shutil
import sys
import tarfile
import unittest

from package_case import HERE, RELEASE, PackageCase, run

LAYOUT = RELEASE / "layout/platformio"
# pio requests the list of licences from the network; only this is replaced.
PIO = (
    "import sys; from platformio.package.manifest.schema import ManifestSchema as schema; "
    "schema.load_spdx_licenses = staticmethod(lambda: {'licenses': [{'licenseId': 'MIT'}]}); "
    "from platformio.__main__ import main; sys.exit(main())"
)
SCONS = "import sys\nsys.path.insert(0, %r)\nfrom SCons.Script import main\nmain()\n"


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


class PlatformIO(PackageCase):
    def setUp(self):
        super().setUp()
        self.core = self.work / "core"
        shutil.copytree(LAYOUT, self.work / "davar")

    def pio(self, *words, status=0, **variables):
        return run(
            sys.executable,
            "-c",
            PIO,
            *words,
            folder=self.work,
            status=status,
            HOME=str(self.work),
            PLATFORMIO_CORE_DIR=str(self.core),
            PLATFORMIO_SETTING_ENABLE_TELEMETRY="no",
            PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL="999999",
            **variables,
        )

    def tools(self):
        """A platform with the name `native`, and scons from PyPI as the package that PlatformIO
        builds with.
        """
        major, minor, patch = importlib.metadata.version("scons").split(".")
        scons = self.core / "packages/tool-scons"
        install(scons, "tool", "tool-scons", f"4.{major}{int(minor):02}{int(patch):02}.0")
        (scons / "scons.py").write_text(
            SCONS % str(importlib.metadata.distribution("scons").locate_file(""))
        )
        native = self.core / "platforms/native"
        install(native, "platform", "native", "1.0.0", title="native", packages={})
        (native / "builder").mkdir()
        (native / "platform.py").write_text(
            "from platformio.platform.base import PlatformBase\n\n\n"
            "class NativePlatform(PlatformBase):\n    pass\n"
        )
        shutil.copy(HERE / "platformio_platform.py", native / "builder/main.py")

    def test_pio_packs_it(self):
        self.pio("pkg", "pack", self.work / "davar", "-o", self.work / "davar.tar.gz")
        with tarfile.open(self.work / "davar.tar.gz") as packed:
            names = set(packed.getnames())
        ours = {path.relative_to(LAYOUT).as_posix() for path in LAYOUT.rglob("*") if path.is_file()}
        self.assertEqual(set(), ours - names)

    def test_pio_rejects_a_wrong_manifest(self):
        manifest = self.work / "davar/library.json"
        good = manifest.read_text()
        for wrong, why in (
            (
                re.sub(r'"version": "[^"]*"', '"version": "one"', good),
                "Invalid semantic versioning",
            ),
            (good.replace('"MIT"', '"Mine"'), "SPDX license"),
        ):
            manifest.write_text(wrong)
            self.assertIn(why, self.pio("pkg", "pack", self.work / "davar", status=1))

    def test_the_example_runs_here(self):
        self.tools()
        self.pio("run", "-d", self.work / "davar/examples/arw")
        said = run(self.work / "davar/examples/arw/.pio/build/native/program.elf").splitlines()
        found = [
            re.match(r" *([\d.]+) s  ARW ([\d.]+) \(([\d.]+) to ([\d.]+)\)", line) for line in said
        ]
        told = [float(line.split()[0]) for line in said if "the noise has changed" in line]
        self.assertEqual(1, len(told), said)
        self.assertTrue(60 < told[0] < 62, told)  # the noise triples at 60 s
        for match in found:
            second, value = float(match[1]), float(match[2])
            if 30 < second <= 60 or second > 90:
                self.assertLess(abs(value / (0.3 if second <= 60 else 0.9) - 1), 0.1, match[0])

    def test_the_example_is_built_for_a_cortex_m4_with_flags_of_the_package(self):
        self.tools()
        said = self.pio(
            "run", "-v", "-d", self.work / "davar/examples/arw", DAVAR_PREFIX="arm-none-eabi-"
        )
        own = [line for line in said.splitlines() if "glr.c" in line and "-c" in line.split()]
        self.assertTrue(
            own
            and all("-ffp-contract=off" in line and "-DDAVAR_TAUS_MAX=8" in line for line in own),
            own,
        )
        self.assertIn(
            "Tag_CPU_arch: v7E-M",
            run(
                "arm-none-eabi-readelf",
                "-A",
                self.work / "davar/examples/arw/.pio/build/native/program.elf",
            ),
        )


if __name__ == "__main__":
    unittest.main()
