#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs conanfile.py without Conan: stand-ins take the place of the few names of it that the recipe uses.

    python3 tests/packaging/conan_test.py ROOT VERSION

Checks the version, the requirements for every option, that CMake knows every variable that is set, that what is packaged is all headers
and the license, and that the components are the targets of the CMake package.
"""
import glob
import importlib.util
import os
import re
import shutil
import sys
import tempfile
import types


def module(name, **members):
    made = types.ModuleType(name)
    made.__dict__.update(members)
    sys.modules[name] = made


class Recorder:
    """Takes any call and any attribute, and remembers nothing."""

    def __init__(self, *_):
        self.cache_variables = {}

    def __getattr__(self, _):
        return lambda *arguments, **named: None


class Toolchain(Recorder):
    last = None

    def __init__(self, *_):
        super().__init__()
        Toolchain.last = self


class Component:
    def __init__(self):
        self.properties, self.requires, self.defines = {}, [], []

    def set_property(self, name, value):
        self.properties[name] = value


class Components(dict):
    def __missing__(self, key):
        self[key] = Component()
        return self[key]


class ConanFile:
    pass


def copy(_, pattern, source, destination):
    for path in glob.glob(os.path.join(source, "**", pattern), recursive=True):
        target = os.path.join(destination, os.path.relpath(path, source))
        os.makedirs(os.path.dirname(target), exist_ok=True)
        shutil.copy(path, target)


def load(_, path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def main():
    root, version = sys.argv[1:]
    module("conan", ConanFile=ConanFile)
    module("conan.tools")
    module("conan.tools.build", check_min_cppstd=lambda *_: None)
    module("conan.tools.cmake", CMake=Recorder, CMakeDeps=Recorder, CMakeToolchain=Toolchain, cmake_layout=lambda *_: None)
    module("conan.tools.files", copy=copy, load=load)
    sys.dont_write_bytecode = True
    specification = importlib.util.spec_from_file_location("conanfile", os.path.join(root, "conanfile.py"))
    recipe_module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(recipe_module)

    with open(os.path.join(root, "CMakeLists.txt"), encoding="utf-8") as file:
        cmake = file.read()
    headers = glob.glob(os.path.join(root, "include", "**", "*.hpp"), recursive=True)
    assert len(headers) > 50, headers
    for pattern in recipe_module.Slice2meshRecipe.exports_sources:
        assert glob.glob(os.path.join(root, pattern)), pattern

    for pipeline in (True, False):
        for with_zlib in (True, False):
            recipe = recipe_module.Slice2meshRecipe()
            recipe.options = types.SimpleNamespace(pipeline=pipeline, with_zlib=with_zlib)
            assert set(recipe_module.Slice2meshRecipe.options) == set(vars(recipe.options)) == set(recipe.default_options)
            recipe.recipe_folder = root
            recipe.set_version()
            assert recipe.version == version, (recipe.version, version)
            wanted = []
            recipe.requires = wanted.append
            recipe.requirements()
            recipe.validate()
            recipe.layout()
            recipe.generate()
            names = {text.split("/")[0] for text in wanted}
            assert names == {"eigen"} | ({"cgal"} if pipeline else set()) | ({"zlib"} if with_zlib else set()), names
            for text in wanted:
                assert re.fullmatch(r"[a-z0-9_.+-]+/\[>=[0-9.]+ <[0-9.]+\]", text), text
            variables = Toolchain.last.cache_variables
            assert variables["SLICE2MESH_CORE_ONLY"] is (not pipeline)
            for name in variables:
                assert re.search(r"(option|set)\(%s[ \n]" % name, cmake), "CMake does not know " + name
            with tempfile.TemporaryDirectory() as folder:
                recipe.source_folder, recipe.package_folder = root, folder
                recipe.package()
                packaged = glob.glob(os.path.join(folder, "include", "slice2mesh", "**", "*.hpp"), recursive=True)
                assert len(packaged) == len(headers), (len(packaged), len(headers))
                assert os.path.exists(os.path.join(folder, "licenses", "LICENSE"))
            recipe.cpp_info = Component()
            recipe.cpp_info.components = Components()
            recipe.package_info()
            targets = {part.properties["cmake_target_name"] for part in recipe.cpp_info.components.values()}
            assert targets == {"slice2mesh::core"} | ({"slice2mesh::slice2mesh"} if pipeline else set()), targets
            assert bool(recipe.cpp_info.components["core"].defines) == with_zlib
            required = {name.split("::")[0] for part in recipe.cpp_info.components.values() for name in part.requires}
            assert required - {"core"} == names, (required, names)
    print("conanfile.py: slice2mesh/%s, %d headers" % (version, len(headers)))


if __name__ == "__main__":
    main()
