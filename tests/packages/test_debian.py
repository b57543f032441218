"""The Debian packages: no complaint from lintian, and programs that use what dpkg installed."""

import os
import re
import subprocess
import unittest

from package_case import CONSUMER, ROOT, SAYS, PackageCase, build, package, run

LIBRARY, PROGRAMS = package("libdavar-dev_*.deb"), package("davar-tools_*.deb")


class Debian(PackageCase):
    def setUp(self):
        super().setUp()
        self.root = self.work / "root"
        self.root.mkdir()
        for deb in (LIBRARY, PROGRAMS):
            if os.geteuid() == 0:  # into a separate root: this machine's packages stay unchanged
                (self.root / "var/lib/dpkg/info").mkdir(parents=True, exist_ok=True)
                (self.root / "var/lib/dpkg/updates").mkdir(exist_ok=True)
                (self.root / "var/lib/dpkg/status").touch()
                run(
                    "dpkg",
                    f"--root={self.root}",
                    "--force-depends",
                    "-i",
                    deb,
                    PATH=f"{os.environ['PATH']}:/usr/sbin:/sbin",
                )
            else:
                run("dpkg-deb", "-x", deb, self.root)

    def test_lintian_finds_no_error(self):
        said = run("lintian", "--allow-root", "--fail-on", "error", LIBRARY, PROGRAMS)
        self.assertEqual(
            {"no-manual-page"}, set(re.findall(r"^W: \S+ (\S+)", said, re.MULTILINE))
        )  # davar-sim --help is the manual

    def test_the_control_file_lists_the_dependencies(self):
        needs = subprocess.run(
            ["dpkg-deb", "-f", PROGRAMS, "Depends"], text=True, stdout=subprocess.PIPE, check=True
        ).stdout
        for library in ("libc6", "zlib1g", "libgpiod2"):
            self.assertIn(library, needs)

    def test_find_package_finds_it(self):
        build(
            ROOT / "tests/consumer/find_package",
            self.work / "user",
            f"-DCMAKE_PREFIX_PATH={self.root}/usr",
            "-DCMAKE_LIBRARY_ARCHITECTURE=" + run("gcc", "-print-multiarch").strip(),
        )
        self.assertRegex(run(self.work / "user/consumer"), SAYS)

    def test_pkg_config_finds_it(self):
        folder = next(self.root.rglob("davar.pc")).parent
        flags = run(
            "pkg-config", "--cflags", "--libs", "davar", PKG_CONFIG_PATH=str(folder)
        ).split()
        run("gcc", CONSUMER, "-o", self.work / "consumer", *flags)
        self.assertRegex(run(self.work / "consumer"), SAYS)
        self.assertIn(
            run("pkg-config", "--modversion", "davar", PKG_CONFIG_PATH=str(folder)).strip(),
            LIBRARY.name,
        )

    def test_the_programs_run(self):
        said = run(
            self.root / "usr/bin/davar-sim",
            ROOT / "data/demo_disturbance.csv.gz",
            "--lsb",
            "0.001",
            "--stride",
            "600",
        )
        self.assertEqual("epoch", said.split(",")[0])
        self.assertIn("usage", run(self.root / "usr/bin/davar-node", "--help"))


if __name__ == "__main__":
    unittest.main()
