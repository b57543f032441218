"""Other projects can use davar as a subdirectory. After an installation: test_install.py."""

import subprocess
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def run(*command):
    """Runs a command and returns its output; a failure shows all of it."""
    done = subprocess.run(
        [str(word) for word in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert done.returncode == 0, f"{command}:\n{done.stdout}"
    return done.stdout


def build(source, binary, *settings):
    run("cmake", "-S", source, "-B", binary, *settings)
    run("cmake", "--build", binary)


class Consumer(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def assert_works(self, program):
        self.assertRegex(run(program), r"^davar \d+\.\d+\.\d+ epoch 99 window 60\n$")

    def test_add_subdirectory_builds_the_library_and_nothing_else(self):
        build(HERE / "add_subdirectory", self.work / "user", f"-DDAVAR_SOURCE={ROOT}")
        self.assert_works(self.work / "user/consumer")
        self.assertFalse(list(self.work.rglob("davar-sim*")))
        self.assertFalse(list(self.work.rglob("unity*")))

    def test_add_subdirectory_in_a_project_that_builds_in_unity(self):
        build(
            HERE / "add_subdirectory",
            self.work / "user",
            f"-DDAVAR_SOURCE={ROOT}",
            "-DCMAKE_UNITY_BUILD=ON",
            "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0",
        )  # each room, except the two pipelines, as one
        self.assert_works(self.work / "user/consumer")
        self.assertTrue(list(self.work.rglob("unity_0_c.c")))


if __name__ == "__main__":
    unittest.main()
