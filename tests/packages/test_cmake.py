"""The source archive: FetchContent accepts it by its checksum, and the disabled features of a build
reach the user through pkg-config.
"""

import re
import unittest

from package_case import CONSUMER, HERE, RELEASE, ROOT, SAYS, PackageCase, build, package, run

SOURCE = package("davar-[0-9]*.tar.gz")
SUM = re.search(
    rf"^(\w+)  {re.escape(SOURCE.name)}$", (RELEASE / "SHA256SUMS").read_text(), re.MULTILINE
)[1]


class Source(PackageCase):
    def test_fetch_content(self):
        build(
            HERE / "fetch_content",
            self.work / "user",
            f"-DDAVAR_URL=file://{SOURCE}",
            f"-DDAVAR_SHA256={SUM}",
        )
        self.assertRegex(run(self.work / "user/consumer"), SAYS)

    def test_another_archive_is_rejected(self):
        wrong = run(
            "cmake",
            "-S",
            HERE / "fetch_content",
            "-B",
            self.work / "user",
            f"-DDAVAR_URL=file://{SOURCE}",
            f"-DDAVAR_SHA256={SUM[::-1]}",
            status=1,
        )
        self.assertRegex(wrong, "(?i)hash mismatch|does not match")

    def test_pkg_config_reports_disabled_features_wherever_installed(self):
        build(
            ROOT,
            self.work / "davar",
            "-DDAVAR_BUILD_TESTS=OFF",
            "-DDAVAR_BUILD_SIM=OFF",
            "-DDAVAR_GRID=0",
            "-DDAVAR_TAUS_MAX=8",
        )
        run("cmake", "--install", self.work / "davar", "--prefix", self.work / "first")
        (self.work / "first").rename(self.work / "second")
        where = str(next((self.work / "second").rglob("davar.pc")).parent)
        flags = run("pkg-config", "--cflags", "--libs", "davar", PKG_CONFIG_PATH=where).split()
        self.assertLessEqual({"-DDAVAR_GRID=0", "-DDAVAR_TAUS_MAX=8"}, set(flags))
        run("gcc", CONSUMER, "-o", self.work / "consumer", *flags)
        self.assertRegex(run(self.work / "consumer"), SAYS)


if __name__ == "__main__":
    unittest.main()
