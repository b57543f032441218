"""conan create with its test package, for this machine and for a Cortex-M4; what a build leaves out reaches the user."""

import os
import re
import shutil
import unittest

from package_case import HERE, ROOT, TOOLS, PackageCase, run

PROFILE = HERE / "cortex-m4.profile"
CREATE = ("create", ROOT / "packaging/conan", "-c", "tools.cmake.cmake_layout:test_folder=$TMP")


class Conan(PackageCase):
    def conan(self, *words):
        return run(TOOLS / "conan", *words, CONAN_HOME=str(self.work / "conan"), PATH=f"{TOOLS}:{os.environ['PATH']}")

    def setUp(self):
        super().setUp()
        self.conan("profile", "detect")

    def test_on_this_machine(self):
        said = self.conan(*CREATE)
        self.assertRegex(said, r"(?m)^davar \d+\.\d+\.\d+ epoch 99 window 60$")  # the test package ran
        self.assertEqual([], [path for path in (ROOT / "packaging/conan").rglob("*") if path.name in ("build", "CMakeUserPresets.json")])

    def test_for_a_cortex_m4_with_less(self):
        said = self.conan(*CREATE, "--profile:host", PROFILE, "-o", "davar/*:grid=False", "-o", "davar/*:adaptive=False")
        self.assertRegex(said, r"Linking C executable consumer")
        for name in ("GRID", "ADAPTIVE", "TRACKING"):
            self.assertRegex(said, rf"DAVAR_{name}\S*0")
        library = next((self.work / "conan").rglob("p/lib/libdavar.a"))
        self.assertIn("Tag_CPU_arch: v7E-M", run("arm-none-eabi-readelf", "-A", library))
        self.assertIn("copyright", (library.parent.parent / "licenses/LICENSE").read_text().lower())

    def test_a_recipe_outside_its_tree_says_so(self):
        shutil.copytree(ROOT / "packaging/conan", self.work / "alone/conan")
        said = run(TOOLS / "conan", "create", self.work / "alone/conan", status=1, CONAN_HOME=str(self.work / "conan"))
        self.assertTrue(re.search(r"version\.h", said), said)


if __name__ == "__main__":
    unittest.main()
