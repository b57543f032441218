"""The CMSIS-Pack: its names agree, and the listed files compile with the listed paths, from the
finished pack.
"""

import re
import xml.etree.ElementTree
import zipfile

import c_library
import pytest
from packaging_tools import CONSUMER, run


@pytest.fixture(scope="module")
def pack(draft, tmp_path_factory):
    """(the pack, unpacked; its description)"""
    folder = tmp_path_factory.mktemp("pack")
    with zipfile.ZipFile(draft.package("*.pack")) as archive:
        assert archive.testzip() is None
        archive.extractall(folder)
    (description,) = folder.glob("*.pdsc")
    return folder, xml.etree.ElementTree.parse(description).getroot()


def files_of(tree, category):
    return [file for file in tree.iter("file") if file.get("category") == category]


def test_names_and_files_agree(pack, draft):
    folder, tree = pack
    vendor, name = tree.findtext("vendor"), tree.findtext("name")
    assert re.fullmatch(r"[-_A-Za-z0-9]+", vendor + name)
    version = tree.find("releases/release").get("version")
    assert draft.package("*.pack").name == f"{vendor}.{name}.{version}.pack"
    wanted = {f"{vendor}.{name}.pdsc", tree.findtext("license")}
    wanted |= {file.get("name") for file in tree.iter("file")}
    for path in wanted:
        assert (folder / path).is_dir() if path.endswith("/") else (folder / path).is_file(), path
    assert all(file.get("name").endswith("/") for file in files_of(tree, "include"))
    sources = [path.relative_to(folder).as_posix() for path in (folder / "src").rglob("*.c")]
    assert [file.get("name") for file in files_of(tree, "source")] == sorted(sources)
    assert len(sources) == len(c_library.SOURCES)


def test_the_listed_files_compile_and_link_for_a_cortex_m4(pack, tmp_path):
    folder, tree = pack
    core = ["-mcpu=cortex-m4", "-mthumb", "-std=c11", "-O0", "-Wall", "-Wextra", "-Werror"]
    include = {file.get("name"): file.get("scope") for file in files_of(tree, "include")}
    sources = [folder / file.get("name") for file in files_of(tree, "source")]
    paths = [f"-I{folder / name}" for name in include]
    run("arm-none-eabi-gcc", *core, *paths, "-c", *sources, folder=tmp_path)
    public = [f"-I{folder / name}" for name, scope in include.items() if scope is None]
    words = [*public, CONSUMER, *tmp_path.glob("*.o"), "-o", tmp_path / "consumer.elf"]
    run("arm-none-eabi-gcc", *core, *words, "--specs=nosys.specs", "-lm")
