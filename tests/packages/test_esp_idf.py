"""The components of ESP-IDF and Zephyr: their Kconfig offers the settings of davar/options.h,
kconfiglib (which Zephyr itself uses) reads it, and IDF's manager packs its component.
"""

import json
import re
import shutil
import tarfile

import pytest
from packaging_tools import ROOT, files_below, run

OPTIONS = ROOT / "packaging/common/Kconfig"
READ = """import json, kconfiglib, sys
config = kconfiglib.Kconfig(sys.argv[1], warn_to_stderr=False)
config.load_config(sys.argv[2])
values = {one.name: one.str_value for one in config.unique_defined_syms}
print(json.dumps([values, config.warnings]))
"""


def test_the_choices_are_those_of_the_header():
    header = (ROOT / "lib/include/davar/options.h").read_text()
    wanted = re.findall(r"#define DAVAR_(\w+) \d+$", header, re.MULTILINE)
    found = re.findall(r"^config DAVAR_(\w+)", OPTIONS.read_text(), re.MULTILINE)
    assert set(found) == set(wanted)
    for name in ("packaging/esp-idf/CMakeLists.txt", "packaging/zephyr/CMakeLists.txt"):
        text = (ROOT / name).read_text()
        assert [one for one in wanted if not re.search(rf"\b(DAVAR_)?{one}\b", text)] == [], name


@pytest.mark.soak
@pytest.mark.parametrize(
    "text, wanted",
    (
        ("", {"DAVAR": "n"}),
        ("CONFIG_DAVAR=y\n", {"DAVAR": "y", "DAVAR_LAWS": "y", "DAVAR_TAUS_MAX": "32"}),
        (
            "CONFIG_DAVAR=y\nCONFIG_DAVAR_LAWS=n\nCONFIG_DAVAR_TAUS_MAX=8\n",
            {"DAVAR_LAWS": "n", "DAVAR_TAUS_MAX": "8", "DAVAR_GRID": "y"},
        ),
        ("CONFIG_DAVAR=y\nCONFIG_DAVAR_TAUS_MAX=33\n", None),
    ),
)
def test_zephyr_reads_the_kconfig(tools, tmp_path, text, wanted):
    module = (ROOT / "zephyr/module.yml").read_text()
    kconfig = ROOT / re.search(r"kconfig: (\S+)", module)[1]
    (tmp_path / "prj.conf").write_text(text)
    said = run(tools / "python", "-c", READ, kconfig, tmp_path / "prj.conf")
    values, warnings = json.loads(said.splitlines()[-1])
    if wanted is None:
        assert any("33" in warning for warning in warnings)
    else:
        assert {name: values[name] for name in wanted} == wanted


@pytest.mark.soak
def test_the_manager_packs_the_component_and_rejects_a_wrong_version(tools, draft, tmp_path):
    component = draft.layout / "esp-idf"
    shutil.copytree(component, tmp_path / "davar")
    command = [tools / "compote", "component", "pack", "--name", "davar"]
    variables = {"IDF_COMPONENT_CHECK_NEW_VERSION": "0", "HOME": str(tmp_path)}
    run(*command, folder=tmp_path / "davar", **variables)
    (archive,) = (tmp_path / "davar/dist").glob("davar_*.tgz")
    with tarfile.open(archive) as packed:
        names = {name.removeprefix("./") for name in packed.getnames()}
    assert files_below(component) <= names
    manifest = tmp_path / "davar/idf_component.yml"
    manifest.write_text(re.sub(r'version: ".*"', 'version: "one"', manifest.read_text()))
    said = run(*command, folder=tmp_path / "davar", status=2, **variables)
    assert 'Invalid field "version"' in said
