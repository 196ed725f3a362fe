# Written from the documentation of vcpkg and not run yet.
#
# An overlay port inside of the sources of pelage: vcpkg install pelage --overlay-ports=packaging/vcpkg. A port
# for a registry takes them with vcpkg_from_git() or vcpkg_from_github().
#
# pelage links zstd::libzstd_shared, which zstd has in triplets with dynamic linkage (x64-linux-dynamic).
cmake_path(SET SOURCE_PATH NORMALIZE "${CURRENT_PORT_DIR}/../..")

vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS
  FEATURES
    vulkan      PELAGE_VULKAN
    gl          PELAGE_GL
    mesh-import PELAGE_MESH_IMPORT
    authoring   PELAGE_AUTHORING
)
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" "dynamic" shared)

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${FEATURE_OPTIONS}
    -DPELAGE_SHARED=${shared}
    -DPELAGE_C_SHARED=${shared}
    -DPELAGE_INSTALL=ON
    -DPELAGE_BUILD_TESTS=OFF
    -DPELAGE_BUILD_SAMPLES=OFF
    -DPELAGE_BUILD_BENCHMARKS=OFF
    -DPELAGE_BUILD_VIEWER=OFF
    # Both configurations, and later builds, share the compiled kernels.
    "-DPELAGE_CODEGEN_CACHE=${CURRENT_BUILDTREES_DIR}/codegen_cache"
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME pelage CONFIG_PATH lib/cmake/pelage)
vcpkg_fixup_pkgconfig()

set(tools pelage-codegen)
if("authoring" IN_LIST FEATURES)
  list(APPEND tools pelage-convert)
endif()
vcpkg_copy_tools(TOOL_NAMES ${tools} AUTO_CLEAN)

file(REMOVE_RECURSE
  "${CURRENT_PACKAGES_DIR}/debug/include"
  "${CURRENT_PACKAGES_DIR}/debug/share"
  "${CURRENT_PACKAGES_DIR}/share/doc"
  "${CURRENT_PACKAGES_DIR}/share/man")
file(INSTALL "${CURRENT_PORT_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
