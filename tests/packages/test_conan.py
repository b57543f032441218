"""conan create with its test package, for this machine and for a Cortex-M4. The disabled features
of a build reach the user.
"""

import os
import re
import shutil

import pytest
import release
from packaging_tools import HERE, ROOT, files_below, run

CREATE = ("create", "packaging/conan")
pytestmark = pytest.mark.soak


@pytest.fixture
def tree(tmp_path):
    for name in release.tree():
        release.copy(ROOT / name, tmp_path / "davar" / name)
    return tmp_path / "davar"


@pytest.fixture
def conan(tools, tree, tmp_path):
    def conan(*words, status=0):
        home, path = str(tmp_path / "conan"), f"{tools}:{os.environ['PATH']}"
        words = [tools / "conan", *words]
        return run(*words, folder=tree, status=status, CONAN_HOME=home, PATH=path)

    conan("profile", "detect")
    return conan


def test_on_this_machine(conan, tree):
    def files():
        return {
            name
            for name in files_below(tree)
            if not name.startswith("build/") and "__pycache__" not in name
        }

    before = files()
    # the test package ran
    assert re.search(r"(?m)^davar \d+\.\d+\.\d+ epoch 99 window 60$", conan(*CREATE))
    assert files() == before


def test_for_a_cortex_m4_with_less(conan, tmp_path):
    less = ("-o", "davar/*:q31=False", "-o", "davar/*:laws=False")
    said = conan(*CREATE, "--profile:host", HERE / "cortex-m4.profile", *less)
    assert "Linking C executable consumer" in said
    for name in ("Q31", "LAWS"):
        assert re.search(rf"DAVAR_{name}\S*0", said)
    library = next((tmp_path / "conan").rglob("p/lib/libdavar.a"))
    assert "Tag_CPU_arch: v7E-M" in run("arm-none-eabi-readelf", "-A", library)
    assert "copyright" in (library.parent.parent / "licenses/LICENSE").read_text().lower()


def test_a_recipe_outside_its_tree_is_reported(conan, tmp_path):
    shutil.copytree(ROOT / "packaging/conan", tmp_path / "alone/conan")
    assert re.search(r"pyproject\.toml", conan("create", tmp_path / "alone/conan", status=1))
