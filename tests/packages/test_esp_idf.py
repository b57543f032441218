"""The component of ESP-IDF: its manager packs it, its Kconfig is read, and it is compiled for RV32
with a stub of IDF's CMake function.
"""

import json
import re
import shutil
import tarfile
import unittest

import kconfiglib
from package_case import HERE, RELEASE, TOOLS, PackageCase, build, run

COMPONENT = RELEASE / "layout/esp-idf"
RV32 = (
    "-DCMAKE_SYSTEM_NAME=Generic",
    "-DCMAKE_C_COMPILER=riscv64-unknown-elf-gcc",
    "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
    "-DCMAKE_C_FLAGS=-march=rv32imac -mabi=ilp32 --specs=picolibc.specs",
)  # the ESP32-C6's


class EspIdf(PackageCase):
    def pack(self, status=0):
        return run(
            TOOLS / "compote",
            "component",
            "pack",
            "--name",
            "davar",
            folder=self.work / "davar",
            status=status,
            IDF_COMPONENT_CHECK_NEW_VERSION="0",
            HOME=str(self.work),
        )

    def setUp(self):
        super().setUp()
        shutil.copytree(COMPONENT, self.work / "davar")

    def test_the_manager_packs_it(self):
        self.pack()
        (archive,) = (self.work / "davar/dist").glob("davar_*.tgz")
        with tarfile.open(archive) as packed:
            names = {name.removeprefix("./") for name in packed.getnames()}
        ours = {
            path.relative_to(COMPONENT).as_posix()
            for path in COMPONENT.rglob("*")
            if path.is_file()
        }
        self.assertEqual(set(), ours - names)

    def test_the_manager_rejects_a_wrong_version(self):
        manifest = self.work / "davar/idf_component.yml"
        manifest.write_text(re.sub(r'version: ".*"', 'version: "one"', manifest.read_text()))
        self.assertIn('Invalid field "version"', self.pack(status=2))

    def test_it_compiles_with_the_choices_of_its_kconfig(self):
        chosen = self.work / "sdkconfig"
        chosen.write_text("CONFIG_DAVAR_TAUS_MAX=8\n# CONFIG_DAVAR_LAWS is not set\n")
        config = kconfiglib.Kconfig(str(COMPONENT / "Kconfig"))
        config.load_config(str(chosen))
        settings = self.work / "sdkconfig.cmake"
        settings.write_text(
            "".join(
                f"set(CONFIG_{symbol.name} {json.dumps(symbol.str_value.strip('n'))})\n"
                for symbol in config.unique_defined_syms
            )
        )
        build(
            HERE / "esp_idf",
            self.work / "build",
            f"-DCOMPONENT={COMPONENT}",
            f"-DSDKCONFIG={settings}",
            "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
            *RV32,
        )
        commands = json.loads((self.work / "build/compile_commands.json").read_text())
        self.assertGreater(len(commands), 20)
        for command in commands:
            for definition in ("TAUS_MAX=8", "LAWS=0", "Q15=1", "CENTRED=1"):
                self.assertIn(f"-DDAVAR_{definition}", command["command"])
        symbols = set(
            run("riscv64-unknown-elf-nm", "-j", self.work / "build/davar/lib__idf_davar.a").split()
        )
        self.assertIn("davar_take_8_taus", symbols)


if __name__ == "__main__":
    unittest.main()
