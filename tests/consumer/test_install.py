"""Other projects use davar as a subdirectory, or installed by the command of docs/PACKAGES.md as
typed, for this machine and for microcontrollers.
"""

import re

import pytest
from compiling import ROOT, attempt, run

HERE = ROOT / "tests/consumer"
PAGE = (ROOT / "docs/PACKAGES.md").read_text(encoding="utf-8")
TYPED = re.search(r"^    (cmake -S davar .*)$", PAGE, re.MULTILINE)[1]
SAYS = r"davar \d+\.\d+\.\d+ epoch 99 window 60\n"
PARTS_SAY = "parts ok ok ok ok 1 1 0 6 0 0 8.72665e-05\n"
ARM = f"-DCMAKE_TOOLCHAIN_FILE={ROOT / 'port/bare_metal/targets/cortex_m.cmake'}"
BARE = (
    "-DCMAKE_EXE_LINKER_FLAGS=--specs=nosys.specs",
    "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
)
LONG = pytest.mark.soak


@pytest.mark.parametrize("unity", (False, pytest.param(True, marks=LONG)))
def test_add_subdirectory_builds_the_library_and_nothing_else(tmp_path, unity):
    # in a unity build each room is one source, except the two pipelines
    words = ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0"] if unity else []
    run("cmake", "-S", HERE / "add_subdirectory", "-B", tmp_path, f"-DDAVAR_SOURCE={ROOT}", *words)
    run("cmake", "--build", tmp_path)
    assert re.fullmatch(SAYS, run(tmp_path / "consumer"))
    assert run(tmp_path / "parts") == PARTS_SAY
    assert bool(list(tmp_path.rglob("unity_0_c.c"))) == unity
    assert not [*tmp_path.rglob("davar-sim*"), *tmp_path.rglob("unity.c*")]


@pytest.mark.parametrize(
    "core, kind",
    (
        ("host", ""),
        ("cortex-m4f", "Debug"),
        pytest.param("host", "Debug", marks=LONG),
        pytest.param("host", "MinSizeRel", marks=LONG),
        pytest.param("cortex-m0", "", marks=LONG),
        pytest.param("cortex-m4f", "", marks=LONG),
        pytest.param("cortex-m4f", "MinSizeRel", marks=LONG),
        pytest.param("cortex-m7", "", marks=LONG),
    ),
)
def test_installed_as_the_page_says(tmp_path, core, kind):
    (tmp_path / "davar").symlink_to(ROOT)
    settings = [] if core == "host" else [ARM, f"-DDAVAR_TARGET={core}"]
    settings += [f"-DCMAKE_BUILD_TYPE={kind}"] if kind else []
    run("sh", "-ec", TYPED.replace("-B b", " ".join(["-B b", *settings])), folder=tmp_path)
    found = {path.name for path in tmp_path.joinpath("P").rglob("*") if path.is_file()}
    assert {"libdavar.a", "davar.h", "options.h", "libdavar_cascade.a", "torn.h"} <= found
    settings += [] if core == "host" else BARE
    where = f"-DCMAKE_PREFIX_PATH={tmp_path / 'P'}"
    run("cmake", "-S", HERE / "find_package", "-B", tmp_path / "user", where, *settings)
    run("cmake", "--build", tmp_path / "user")
    if core == "host":
        assert re.fullmatch(SAYS, run(tmp_path / "user/consumer"))
        assert run(tmp_path / "user/parts") == PARTS_SAY
    if not kind:  # the installed library is optimised by default
        assert "CMAKE_BUILD_TYPE:STRING=Release" in (tmp_path / "b/CMakeCache.txt").read_text()


def test_a_part_that_does_not_exist_is_refused_by_its_name(tmp_path):
    (tmp_path / "davar").symlink_to(ROOT)
    run("sh", "-ec", TYPED, folder=tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(consumer LANGUAGES C)\n"
        "find_package(davar REQUIRED COMPONENTS cascade filters)\n"
    )
    words = ("-S", tmp_path, "-B", tmp_path / "user", f"-DCMAKE_PREFIX_PATH={tmp_path / 'P'}")
    status, said = attempt("cmake", *words)
    assert status != 0
    assert "davar has no component filters" in " ".join(said.split())
