"""tools/support/setup.sh: two tools that need the same thing make it once, and presets newer than a
build folder are read again.
"""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
class Setup(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)
        (self.work / "tools/support").mkdir(parents=True)
        shutil.copy(ROOT / "tools/support/setup.sh", self.work / "tools/support")

    def start(self, words):
        return subprocess.Popen(
            ["bash", "-c", f". tools/support/setup.sh && {words}"],
            cwd=self.work,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def test_three_tools_that_need_the_same_python_make_it_once(self):
        (self.work / "pins.txt").write_text("# nothing\n")
        started = [self.start("python_environment venv pins.txt") for _ in range(3)]
        said = [process.communicate() for process in started]
        self.assertEqual([0] * 3, [process.returncode for process in started], said)
        self.assertEqual(
            {f"{self.work.resolve()}/build/venv/bin/python\n"}, {out for out, _ in said}
        )
        self.assertEqual(1, "".join(error for _, error in said).count("making build/venv"))
        subprocess.run([self.work / "build/venv/bin/python", "-c", "import pip"], check=True)

    def test_a_build_folder_is_configured_again_when_the_presets_are_newer(self):
        (self.work / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.22)\nproject(one LANGUAGES NONE)\n"
            "add_custom_target(${WHICH})\n"
        )
        presets = self.work / "CMakePresets.json"
        text = (
            '{"version": 3, "configurePresets": [{"name": "p", "generator": "Unix Makefiles", '
            '"binaryDir": "${sourceDir}/build/p", "cacheVariables": {"WHICH": "@"}}],'
            '"buildPresets": [{"name": "p", "configurePreset": "p"}]}'
        )
        presets.write_text(text.replace("@", "first"))
        done = self.start("build p first")
        self.assertEqual(("", 0), (done.communicate()[1], done.returncode))
        presets.write_text(text.replace("@", "second"))
        later = (self.work / "build/p/configured").stat().st_mtime + 2
        os.utime(presets, (later, later))
        done = self.start("build p second")
        self.assertEqual(("", 0), (done.communicate()[1], done.returncode))
