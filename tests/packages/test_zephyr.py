"""The module of Zephyr: kconfiglib, which Zephyr itself uses, reads its Kconfig. The example is
built with a stub of Zephyr's CMake functions and sensor interface, and reports the angle random
walk of a simulated gyro.
"""

import json
import re
import unittest

import kconfiglib
import yaml
from package_case import HERE, ROOT, PackageCase, build, run

MODULE = yaml.safe_load((ROOT / "zephyr/module.yml").read_text())
KCONFIG, CMAKE = ROOT / MODULE["build"]["kconfig"], ROOT / MODULE["build"]["cmake"]
EXAMPLE = ROOT / "examples/zephyr"


class Zephyr(PackageCase):
    def settings(self, text):
        """{symbol: value} of Kconfig for a prj.conf. It has no symbols of Zephyr itself."""
        (self.work / "prj.conf").write_text(text)
        config = kconfiglib.Kconfig(str(KCONFIG), warn_to_stderr=False)
        config.load_config(str(self.work / "prj.conf"))
        self.warnings = config.warnings
        return {
            symbol.name: symbol.str_value
            for symbol in config.unique_defined_syms
            if symbol.visibility or symbol.str_value != "n"
        }

    def test_the_kconfig(self):
        self.assertEqual("n", self.settings("")["DAVAR"])
        found = self.settings("CONFIG_DAVAR=y\n")
        self.assertEqual(("y", "32"), (found["DAVAR_LAWS"], found["DAVAR_TAUS_MAX"]))
        found = self.settings("CONFIG_DAVAR=y\nCONFIG_DAVAR_LAWS=n\nCONFIG_DAVAR_TAUS_MAX=8\n")
        self.assertEqual(("n", "8"), (found.get("DAVAR_LAWS", "n"), found["DAVAR_TAUS_MAX"]))
        self.settings("CONFIG_DAVAR=y\nCONFIG_DAVAR_TAUS_MAX=33\n")
        self.assertTrue(any("33" in warning for warning in self.warnings), self.warnings)

    def test_the_choices_are_those_of_the_header(self):
        header = (ROOT / "lib/include/davar/options.h").read_text()
        wanted = set(re.findall(r"#define DAVAR_(\w+) \d+$", header, re.MULTILINE))
        self.assertEqual(
            wanted,
            set(
                re.findall(
                    r"^config DAVAR_(\w+)",
                    (ROOT / "packaging/common/Kconfig").read_text(),
                    re.MULTILINE,
                )
            ),
        )

    def test_the_example(self):
        found = self.settings((EXAMPLE / "prj.conf").read_text())
        lines = [
            f"set(CONFIG_{name} {json.dumps(value.strip('n'))})\n" for name, value in found.items()
        ]
        (self.work / "settings.cmake").write_text("".join(lines))
        build(
            EXAMPLE,
            self.work / "build",
            f"-DZephyr_DIR={HERE / 'zephyr'}",
            f"-DMODULE={CMAKE}",
            f"-DSETTINGS={self.work}/settings.cmake",
        )
        said = run(self.work / "build/firmware").splitlines()
        self.assertGreaterEqual(len(said), 14)  # of 20 s: the window fills in 6 s
        for line in said[5:]:
            window, value, low, high = map(
                float,
                re.fullmatch(
                    r"(\d+) samples, ARW ([\d.]+) \(([\d.]+) to ([\d.]+)\) deg/sqrt\(h\)", line
                ).groups(),
            )
            self.assertEqual(600, window)
            self.assertLess(
                abs(value - 0.3), 0.06, line
            )  # four standard deviations for 600 samples
            self.assertLess(low, value)
            self.assertGreater(high, value)

    def test_without_its_symbol_nothing_is_built(self):
        (self.work / "settings.cmake").write_text("")
        (self.work / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.20)\nproject(none LANGUAGES C)\n"
            f"add_subdirectory({CMAKE} davar)\n"
        )
        build(self.work, self.work / "build")
        self.assertEqual([], list((self.work / "build").rglob("*.a")))


if __name__ == "__main__":
    unittest.main()
