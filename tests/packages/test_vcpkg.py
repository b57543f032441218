"""The port of vcpkg, run with a stub of vcpkg's CMake functions. The installation has the layout
that vcpkg requires.
"""

import json
import unittest
import zipfile

from package_case import HERE, SAYS, PackageCase, package, run


class Vcpkg(PackageCase):
    def test_the_port_installs_the_library_as_vcpkg_wants_it(self):
        with zipfile.ZipFile(package("davar-vcpkg-*.zip")) as archive:
            archive.extractall(self.work)
        port, there = self.work / "davar", self.work / "packages"
        manifest = json.loads((port / "vcpkg.json").read_text())
        self.assertEqual("davar", manifest["name"])
        self.assertEqual(
            {"vcpkg-cmake", "vcpkg-cmake-config"},
            {needed["name"] for needed in manifest["dependencies"]},
        )
        run(
            "cmake",
            f"-DPORT={port}",
            f"-DPACKAGES={there}",
            f"-DVERSION={manifest['version']}",
            "-P",
            HERE / "vcpkg/run.cmake",
        )
        found = {path.relative_to(there).as_posix() for path in there.rglob("*") if path.is_file()}
        self.assertLessEqual(
            {
                "lib/libdavar.a",
                "debug/lib/libdavar.a",
                "include/davar/davar.h",
                "share/davar/davarConfig.cmake",
                "share/davar/copyright",
            },
            found,
        )
        self.assertEqual(
            [],
            [
                name
                for name in found
                if name.startswith(("debug/include", "debug/share", "lib/cmake"))
            ],
        )
        flags = run(
            "pkg-config",
            "--cflags",
            "--libs",
            "davar",
            PKG_CONFIG_PATH=str(there / "lib/pkgconfig"),
        ).split()
        run("gcc", HERE.parent / "consumer/consumer.c", "-o", self.work / "consumer", *flags)
        self.assertRegex(run(self.work / "consumer"), SAYS)


if __name__ == "__main__":
    unittest.main()
