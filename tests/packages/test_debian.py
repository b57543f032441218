"""The Debian packages: no complaint from lintian, and programs that use what dpkg installed."""

import os
import re

import pytest
from packaging_tools import ROOT, SAYS, build, consume, run

PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"


@pytest.fixture(scope="module")
def packages(draft):
    return draft.package("libdavar-dev_*.deb"), draft.package("davar-tools_*.deb")


@pytest.fixture(scope="module")
def root(packages, tmp_path_factory):
    """Both packages installed into a separate root: this machine's packages stay unchanged."""
    root = tmp_path_factory.mktemp("root")
    (root / "var/lib/dpkg/info").mkdir(parents=True)
    (root / "var/lib/dpkg/updates").mkdir()
    (root / "var/lib/dpkg/status").touch()
    for deb in packages:
        if os.geteuid() == 0:
            run("dpkg", f"--root={root}", "--force-depends", "-i", deb, PATH=PATH)
        else:
            run("dpkg-deb", "-x", deb, root)
    return root


def test_lintian_finds_no_error(packages):
    said = run("lintian", "--allow-root", "--fail-on", "error", *packages)
    # davar-sim --help is the manual
    assert set(re.findall(r"^W: \S+ (\S+)", said, re.MULTILINE)) == {"no-manual-page"}


def test_the_control_file_lists_the_dependencies(packages):
    needs = run("dpkg-deb", "-f", packages[1], "Depends")
    assert {"libc6", "zlib1g", "libgpiod2"} <= set(re.findall(r"[\w.+-]+", needs))


def test_find_package_finds_it(root, tmp_path):
    multiarch = run("gcc", "-print-multiarch").strip()
    words = [f"-DCMAKE_PREFIX_PATH={root}/usr", f"-DCMAKE_LIBRARY_ARCHITECTURE={multiarch}"]
    build(ROOT / "tests/consumer/find_package", tmp_path, *words)
    assert re.fullmatch(SAYS, run(tmp_path / "consumer"))


def test_pkg_config_finds_it(root, packages, tmp_path):
    folder = next(root.rglob("davar.pc")).parent
    assert re.fullmatch(SAYS, consume(tmp_path, folder)[1])
    version = run("pkg-config", "--modversion", "davar", PKG_CONFIG_PATH=str(folder)).strip()
    assert packages[0].name.startswith(f"libdavar-dev_{version}_")


def test_the_programs_run(root):
    recording = ROOT / "data/demo_disturbance.csv.gz"
    said = run(root / "usr/bin/davar-sim", recording, "--lsb", "0.001", "--stride", "600")
    assert said.startswith("epoch,")
    assert "usage" in run(root / "usr/bin/davar-node", "--help")
