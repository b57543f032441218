"""conan create with its test package, for this machine and for a Cortex-M4. The disabled features
of a build reach the user.
"""

import os
import re
import shutil
import sys
import unittest

from package_case import HERE, ROOT, TOOLS, PackageCase, run

sys.path.insert(0, str(ROOT / "tools/support"))
import release

PROFILE = HERE / "cortex-m4.profile"
CREATE = ("create", "packaging/conan")


class Conan(PackageCase):
    def conan(self, *words):
        return run(
            TOOLS / "conan",
            *words,
            folder=self.tree,
            CONAN_HOME=str(self.work / "conan"),
            PATH=f"{TOOLS}:{os.environ['PATH']}",
        )

    def setUp(self):
        super().setUp()
        self.tree = self.work / "davar"
        for name in release.tree():
            release.copy(ROOT / name, self.tree / name)
        self.conan("profile", "detect")

    def files(self):
        """Files of the tree, except its build folder and Python's caches."""
        every = (path.relative_to(self.tree) for path in self.tree.rglob("*") if path.is_file())
        return {
            path for path in every if path.parts[0] != "build" and "__pycache__" not in path.parts
        }

    def test_on_this_machine(self):
        before = self.files()
        said = self.conan(*CREATE)
        self.assertRegex(
            said, r"(?m)^davar \d+\.\d+\.\d+ epoch 99 window 60$"
        )  # the test package ran
        self.assertEqual(before, self.files())

    def test_for_a_cortex_m4_with_less(self):
        said = self.conan(
            *CREATE,
            "--profile:host",
            PROFILE,
            "-o",
            "davar/*:grid=False",
            "-o",
            "davar/*:laws=False",
        )
        self.assertRegex(said, r"Linking C executable consumer")
        for name in ("GRID", "LAWS"):
            self.assertRegex(said, rf"DAVAR_{name}\S*0")
        library = next((self.work / "conan").rglob("p/lib/libdavar.a"))
        self.assertIn("Tag_CPU_arch: v7E-M", run("arm-none-eabi-readelf", "-A", library))
        self.assertIn("copyright", (library.parent.parent / "licenses/LICENSE").read_text().lower())

    def test_a_recipe_outside_its_tree_is_reported(self):
        shutil.copytree(ROOT / "packaging/conan", self.work / "alone/conan")
        said = run(
            TOOLS / "conan",
            "create",
            self.work / "alone/conan",
            status=1,
            CONAN_HOME=str(self.work / "conan"),
        )
        self.assertTrue(re.search(r"pyproject\.toml", said), said)


if __name__ == "__main__":
    unittest.main()
