# install() rules and the package that find_package(pelage) reads.
include(CMakePackageConfigHelpers)

set(pelage_targets pelage_headers pelage_passes pelage_core pelage_demo pelage_settings pelage_kernels
  pelage_kernels_spirv pelage_kernels_glsl pelage_kernels_essl pelage_kernels_code pelage-codegen
  pelage_ray_tracing pelage_ray_tracing_kernels pelage_ray_tracing_kernels_spirv
  pelage_ray_tracing_kernels_glsl pelage_ray_tracing_kernels_essl pelage_ray_tracing_kernels_code)
if(PELAGE_HAS_WGSL)
  list(APPEND pelage_targets pelage_kernels_wgsl)
endif()
if(PELAGE_VULKAN)
  list(APPEND pelage_targets pelage_vulkan)
endif()
if(PELAGE_GL)
  list(APPEND pelage_targets pelage_gl)
endif()
if(PELAGE_MESH_IMPORT)
  list(APPEND pelage_targets pelage_mesh_import)
endif()
if(PELAGE_C)
  list(APPEND pelage_targets pelage_c)
endif()

if(PELAGE_AUTHORING)
  list(APPEND pelage_targets pelage_authoring pelage_convert
    pelage_bake_program)
endif()

set(pelage_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pelage)
install(TARGETS ${pelage_targets} EXPORT pelage-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT pelage-targets NAMESPACE pelage:: DESTINATION ${pelage_package_dir})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/pelage DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
# The generated headers: kernels.h, layouts.h, spirv.h and so on.
get_target_property(pelage_generated_include pelage_kernels PELAGE_GENERATED_INCLUDE)
install(DIRECTORY ${pelage_generated_include}/pelage DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")
# The HLSL, for engines that include functions of it in kernels of their own.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/kernels DESTINATION ${CMAKE_INSTALL_DATADIR}/pelage
  FILES_MATCHING PATTERN "*.hlsl" PATTERN "*.hlsli" PATTERN "manifest.json")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
  ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DOCDIR}
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg" PATTERN "man" EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/docs/man/pelage-codegen.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
if(PELAGE_AUTHORING)
  install(FILES ${PROJECT_SOURCE_DIR}/docs/man/pelage-convert.1
    ${PROJECT_SOURCE_DIR}/docs/man/pelage-bake.1
    DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/pelage-config.cmake.in
  ${PROJECT_BINARY_DIR}/pelage-config.cmake
  INSTALL_DESTINATION ${pelage_package_dir}
  PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pelage-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/pelage-config.cmake
  ${PROJECT_BINARY_DIR}/pelage-config-version.cmake
  ${PROJECT_SOURCE_DIR}/cmake/PelageKernels.cmake
  DESTINATION ${pelage_package_dir})
include(PelagePkgConfig)
if(PROJECT_IS_TOP_LEVEL)
  include(PelagePackage)
endif()
