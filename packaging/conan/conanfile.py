"""davar for Conan 2, from a clone or an unpacked archive: conan create packaging/conan."""

import re
import tomllib
from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy

CHOICES = ("q15", "q31", "laws")  # davar/options.h
# addons/CMakeLists.txt: each part, and the others that it uses.
PARTS = {
    **dict.fromkeys(("average", "cascade", "floor", "kalman", "monitor"), ()),
    **dict.fromkeys(("select", "small", "telemetry", "torn"), ()),
    "can": ("floor", "monitor"),
    "telemetry": ("floor",),
    "state": ("cascade",),
}
IN_HEADERS = ("average", "kalman", "torn")  # parts without a library


class Davar(ConanFile):
    name = "davar"
    description = "Dynamic Allan variance on the device"
    topics = ("allan-variance", "gyroscope", "imu", "embedded")
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    languages = "C"
    options = {"taus_max": list(range(1, 33)), **dict.fromkeys(CHOICES, [True, False])}
    default_options = {"taus_max": 32, **dict.fromkeys(CHOICES, True)}

    def init(self):
        """The project table of pyproject.toml, which export puts beside the recipe in the cache."""
        here = Path(self.recipe_folder)
        table = here / "pyproject.toml"
        text = (table if table.is_file() else here / "../../pyproject.toml").read_text(
            encoding="utf-8"
        )
        project = tomllib.loads(text)["project"]
        self.license, self.homepage, self.author = (
            project["license"],
            project["urls"]["Homepage"],
            project["authors"][0]["name"],
        )

    def export(self):
        copy(self, "pyproject.toml", str(Path(self.recipe_folder, "../..")), self.export_folder)

    def set_version(self):
        header = Path(self.recipe_folder, "../../lib/include/davar/version.h").read_text(
            encoding="utf-8"
        )
        self.version = ".".join(
            re.search(rf"#define DAVAR_VERSION_{part} (\d+)", header)[1]
            for part in ("MAJOR", "MINOR", "PATCH")
        )

    def export_sources(self):
        root = str(Path(self.recipe_folder, "../.."))
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "lib/*", "addons/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def _choices(self):
        return {
            "DAVAR_TAUS_MAX": int(str(self.options.taus_max)),
            **{f"DAVAR_{name.upper()}": int(bool(self.options.get_safe(name))) for name in CHOICES},
        }

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update(
            {"DAVAR_BUILD_TESTS": False, "DAVAR_BUILD_SIM": False, **self._choices()}
        )
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install(component="dev")
        copy(self, "LICENSE", self.source_folder, str(Path(self.package_folder, "licenses")))

    def package_info(self):
        core = self.cpp_info.components["davar"]
        core.libs = ["davar"]
        core.defines = [f"{name}={value}" for name, value in self._choices().items()]
        core.set_property("cmake_target_name", "davar::davar")
        if self.settings.os != "Windows":
            core.system_libs = ["m"]
        for name, uses in PARTS.items():
            part = self.cpp_info.components[name]
            part.libs = [] if name in IN_HEADERS else [f"davar_{name}"]
            part.requires = ["davar", *uses]
            part.set_property("cmake_target_name", f"davar::{name}")
        every = self.cpp_info.components["all"]
        every.libs, every.requires = [], list(PARTS)
        every.set_property("cmake_target_name", "davar::all")
