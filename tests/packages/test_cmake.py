"""The source archive: FetchContent accepts it by its checksum, and the disabled features of a build
reach the user through pkg-config.
"""

import re

import pytest
from packaging_tools import HERE, PARTS, PARTS_SAY, ROOT, SAYS, build, consume, run


@pytest.fixture
def settings(draft):
    """Those of the project that fetches: the archive and its checksum."""
    source = draft.package("davar-[0-9]*.tar.gz")
    sums = (draft.folder / "SHA256SUMS").read_text()
    sha = re.search(rf"^(\w+)  {re.escape(source.name)}$", sums, re.MULTILINE)[1]
    return f"-DDAVAR_URL=file://{source}", f"-DDAVAR_SHA256={sha}"


def test_fetch_content(settings, tmp_path):
    build(HERE / "fetch_content", tmp_path, *settings)
    assert re.fullmatch(SAYS, run(tmp_path / "consumer"))


def test_another_archive_is_rejected(settings, tmp_path):
    where, checksum = settings
    name, _, sha = checksum.partition("=")
    words = ["cmake", "-S", HERE / "fetch_content", "-B", tmp_path, where, f"{name}={sha[::-1]}"]
    assert re.search("(?i)hash mismatch|does not match", run(*words, status=1))


def test_pkg_config_reports_disabled_features_wherever_installed(tmp_path):
    options = {"-DDAVAR_Q31=0", "-DDAVAR_TAUS_MAX=8"}
    fast = ["-DDAVAR_BUILD_TESTS=OFF", "-DDAVAR_BUILD_SIM=OFF", "-DCMAKE_BUILD_TYPE=Debug"]
    fast += ["-DCMAKE_INSTALL_LIBDIR=lib"]  # as vcpkg does
    build(ROOT, tmp_path / "davar", *fast, *options)
    run("cmake", "--install", tmp_path / "davar", "--prefix", tmp_path / "first")
    (tmp_path / "first").rename(tmp_path / "second")
    flags, said = consume(tmp_path, next((tmp_path / "second").rglob("davar.pc")).parent)
    assert options <= set(flags)
    assert re.fullmatch(SAYS, said)
    folder = next((tmp_path / "second").rglob("davar.pc")).parent
    parts = [path.stem for path in folder.glob("davar-*.pc")]
    assert len(parts) == len(list(ROOT.glob("addons/*/include")))
    assert consume(tmp_path, folder, PARTS, parts)[1] == PARTS_SAY
    port = (ROOT / "packaging/vcpkg/davar/portfile.cmake").read_text()
    config = tmp_path / "second" / re.search(r"CONFIG_PATH (\S+)\)", port)[1]
    assert (config / "davarConfig.cmake").is_file()
