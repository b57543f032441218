"""The Kconfig of ESP-IDF and Zephyr offers the settings of davar/options.h, and kconfiglib, which
Zephyr itself uses, reads it.
"""

import json
import re

import pytest
from packaging_tools import ROOT, run

READ = """import json, kconfiglib, sys
config = kconfiglib.Kconfig(sys.argv[1], warn_to_stderr=False)
config.load_config(sys.argv[2])
values = {one.name: one.str_value for one in config.unique_defined_syms}
print(json.dumps([values, config.warnings]))
"""


def test_the_choices_are_those_of_the_header():
    header = (ROOT / "lib/include/davar/options.h").read_text()
    wanted = re.findall(r"#define DAVAR_(\w+) \d+$", header, re.MULTILINE)
    choices = (ROOT / "packaging/common/Kconfig").read_text()
    assert set(re.findall(r"^config DAVAR_(\w+)", choices, re.MULTILINE)) == set(wanted)
    for name in ("packaging/esp-idf/CMakeLists.txt", "packaging/zephyr/CMakeLists.txt"):
        text = (ROOT / name).read_text()
        assert [one for one in wanted if not re.search(rf"\b(DAVAR_)?{one}\b", text)] == [], name


@pytest.mark.soak
def test_zephyr_reads_it(tools, tmp_path):
    module = (ROOT / "zephyr/module.yml").read_text()
    kconfig = ROOT / re.search(r"kconfig: (\S+)", module)[1]

    def read(text):
        (tmp_path / "prj.conf").write_text(text)
        said = run(tools / "python", "-c", READ, kconfig, tmp_path / "prj.conf")
        return json.loads(said.splitlines()[-1])

    assert read("")[0]["DAVAR"] == "n"
    values, _ = read("CONFIG_DAVAR=y\nCONFIG_DAVAR_LAWS=n\nCONFIG_DAVAR_TAUS_MAX=8\n")
    assert [values[f"DAVAR_{name}"] for name in ("LAWS", "TAUS_MAX", "Q31")] == ["n", "8", "y"]
    _, warnings = read("CONFIG_DAVAR=y\nCONFIG_DAVAR_TAUS_MAX=33\n")
    assert any("33" in warning for warning in warnings)
