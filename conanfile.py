# SPDX-License-Identifier: MIT
"""Conan 2 recipe of the headers: conan create . (the program is not packaged here)."""
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class Slice2meshRecipe(ConanFile):
    name = "slice2mesh"
    description = "Tetrahedral meshes that conform to the layers of a 3D print, from its slices"
    license = "MIT"
    topics = ("mesh", "additive-manufacturing", "finite-elements", "header-only")
    package_type = "header-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"pipeline": [True, False], "with_zlib": [True, False]}
    # pipeline: False leaves CGAL out, and with it what is under the GPL.
    default_options = {"pipeline": True, "with_zlib": False}
    exports_sources = "CMakeLists.txt", "LICENSE", "cmake/*", "include/*"
    no_copy_source = True

    def set_version(self):
        text = load(self, os.path.join(self.recipe_folder, "include", "slice2mesh", "version.hpp"))
        self.version = re.search(r'SLICE2MESH_VERSION "([0-9.]+)"', text).group(1)

    def requirements(self):
        self.requires("eigen/[>=3.4 <6]")
        if self.options.pipeline:
            self.requires("cgal/[>=5.5 <7]")
        if self.options.with_zlib:
            self.requires("zlib/[>=1.2 <2]")

    def validate(self):
        check_min_cppstd(self, 17)

    def package_id(self):
        self.info.settings.clear()

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("PROGRAM", "TESTS", "EXAMPLES", "BENCHMARKS"):
            toolchain.cache_variables[f"SLICE2MESH_BUILD_{part}"] = False
        toolchain.cache_variables["SLICE2MESH_INSTALL"] = True
        toolchain.cache_variables["SLICE2MESH_WITH_NETCDF"] = "OFF"
        toolchain.cache_variables["SLICE2MESH_CORE_ONLY"] = not self.options.pipeline
        toolchain.cache_variables["SLICE2MESH_WITH_ZLIB"] = bool(self.options.with_zlib)
        toolchain.generate()

    def build(self):
        CMake(self).configure()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        copy(self, "*.hpp", os.path.join(self.source_folder, "include"), os.path.join(self.package_folder, "include"))

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "slice2mesh")
        core = self.cpp_info.components["core"]
        core.set_property("cmake_target_name", "slice2mesh::core")
        core.bindirs = core.libdirs = []
        core.requires = ["eigen::eigen"]
        if self.options.with_zlib:
            core.requires.append("zlib::zlib")
            core.defines = ["SLICE2MESH_HAS_ZLIB"]
        if self.options.pipeline:
            whole = self.cpp_info.components["slice2mesh"]
            whole.set_property("cmake_target_name", "slice2mesh::slice2mesh")
            whole.bindirs = whole.libdirs = []
            whole.requires = ["core", "cgal::cgal"]
