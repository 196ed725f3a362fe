# Written from the documentation of Conan 2 and not run yet.
"""Conan recipe inside of the sources of pelage: conan create packaging/conan --build=missing"""

import os

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd, cross_building
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, save

required_conan_version = ">=2.0"


class PelageConan(ConanFile):
    name = "pelage"
    version = "0.1.0"
    description = "Hair and fur kernels for Vulkan, OpenGL and OpenGL ES from one HLSL source"
    license = "MIT"
    topics = ("hair", "fur", "simulation", "vulkan", "opengl", "hlsl")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {
        "shared": [True, False],
        "vulkan": [True, False],
        "gl": [True, False],
        "mesh_import": [True, False],
        "authoring": [True, False],
    }
    default_options = {
        "shared": False,
        "vulkan": True,
        "gl": True,
        "mesh_import": False,
        "authoring": False,
        # pelage links zstd's shared library.
        "zstd/*:shared": True,
    }

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "cmake/*", "codegen/*",
                        "docs/*", "include/*", "kernels/*", "packaging/*", "runtime/*", "tools/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def validate(self):
        check_min_cppstd(self, 20)
        if self.settings.os != "Linux":
            raise ConanInvalidConfiguration("pelage is built on Linux only")
        if cross_building(self):
            raise ConanInvalidConfiguration("pelage-codegen is built with the library and runs in its build")
        if self.options.authoring and not self.options.mesh_import:
            raise ConanInvalidConfiguration("the option authoring needs mesh_import")

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("zstd/[>=1.4 <2]")
        if self.options.vulkan:
            self.requires("vulkan-headers/[>=1.1]", transitive_headers=True)
            self.requires("vulkan-loader/[>=1.1]")
        if self.options.gl:
            self.requires("egl/system")
            self.requires("opengl/system")
        if self.options.mesh_import:
            self.requires("assimp/[>=5.2 <6]")
        if self.options.authoring:
            self.requires("meshoptimizer/[>=0.18]")
        # Compiled in: who uses pelage does not see them.
        for reference in ("eigen/[>=3.4 <4]", "fmt/[>=9]", "xxhash/[>=0.8 <1]", "nlohmann_json/[>=3.11 <4]",
                          "cli11/[>=2.1 <3]"):
            self.requires(reference, visible=False)
        # Of pelage-codegen.
        for package in ("glslang", "spirv-cross", "spirv-tools"):
            self.requires(f"{package}/[>=1]", visible=False)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["PELAGE_SHARED"] = bool(self.options.shared)
        toolchain.cache_variables["PELAGE_C_SHARED"] = bool(self.options.shared)
        toolchain.cache_variables["PELAGE_VULKAN"] = bool(self.options.vulkan)
        toolchain.cache_variables["PELAGE_GL"] = bool(self.options.gl)
        toolchain.cache_variables["PELAGE_MESH_IMPORT"] = bool(self.options.mesh_import)
        toolchain.cache_variables["PELAGE_AUTHORING"] = bool(self.options.authoring)
        for part in ("TESTS", "SAMPLES", "BENCHMARKS"):
            toolchain.cache_variables[f"PELAGE_BUILD_{part}"] = False
        toolchain.generate()
        CMakeDeps(self).generate()
        # These projects have a CMake package for each library, which pelage asks for; Conan makes one for all.
        for library, package in (("spirv_cross_core", "spirv-cross"), ("spirv_cross_glsl", "spirv-cross"),
                                 ("SPIRV-Tools-opt", "SPIRV-Tools")):
            save(self, os.path.join(self.generators_folder, f"{library}Config.cmake"),
                 f"include(CMakeFindDependencyMacro)\nfind_dependency({package} CONFIG)\n")

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        # pelage's own CMake package has its targets, components and pelage_add_kernels().
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "pelage")]
