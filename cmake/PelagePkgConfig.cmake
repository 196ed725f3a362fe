# pkg-config files for programs that are not built by CMake: a file for each part that was built. Their
# paths are relative to the folder of the file, so that an installed tree can be moved.

# The paths between folders that may be absolute or relative to the prefix.
set(pc_folder ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_prefix ${pc_folder} ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
file(RELATIVE_PATH pc_libdir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_LIBDIR})
file(RELATIVE_PATH pc_includedir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
set(pc_cflags)
if(PELAGE_SHARED)
  set(pc_cflags " -DPELAGE_SHARED")
endif()

# pelage_pkgconfig(NAME DESCRIPTION LIBRARIES names... [REQUIRES packages...] [PRIVATE packages...]
# [HEADERS packages...] [SYSTEM names...]): HEADERS are packages whose headers are included, and nothing is
# linked. A shared library knows which packages (PRIVATE) and libraries without a package (SYSTEM) it needs;
# for static ones every program links them.
function(pelage_pkgconfig name description)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "LIBRARIES;REQUIRES;PRIVATE;HEADERS;SYSTEM")
  set(pc_name ${name})
  set(pc_description ${description})
  set(pc_requires ${arg_REQUIRES})
  set(pc_requires_private ${arg_HEADERS})
  set(pc_libs ${arg_LIBRARIES})
  if(PELAGE_SHARED)
    list(APPEND pc_requires_private ${arg_PRIVATE})
  else()
    list(APPEND pc_requires ${arg_PRIVATE})
    list(APPEND pc_libs ${arg_SYSTEM})
  endif()
  list(TRANSFORM pc_libs PREPEND "-l")
  foreach(list pc_requires pc_requires_private)
    string(REPLACE ";" ", " ${list} "${${list}}")
  endforeach()
  string(REPLACE ";" " " pc_libs "${pc_libs}")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/pelage.pc.in ${PROJECT_BINARY_DIR}/pkgconfig/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

pelage_pkgconfig(pelage-kernels "Tables and pass lists of hair and fur kernels"
  LIBRARIES pelage_kernels pelage_passes PRIVATE libzstd)
pelage_pkgconfig(pelage-spirv "Hair and fur kernels as SPIR-V"
  LIBRARIES pelage_kernels_spirv REQUIRES pelage-kernels)
pelage_pkgconfig(pelage-glsl "Hair and fur kernels as GLSL 4.50"
  LIBRARIES pelage_kernels_glsl REQUIRES pelage-kernels)
pelage_pkgconfig(pelage-essl "Hair and fur kernels as ESSL 3.20"
  LIBRARIES pelage_kernels_essl REQUIRES pelage-kernels)
if(PELAGE_HAS_WGSL)
  pelage_pkgconfig(pelage-wgsl "Hair and fur kernels as WGSL"
    LIBRARIES pelage_kernels_wgsl REQUIRES pelage-kernels)
endif()
pelage_pkgconfig(pelage "Scenes of hair and fur as lists of GPU passes, and generated hair"
  LIBRARIES pelage_demo pelage_core REQUIRES pelage-kernels)
pelage_pkgconfig(pelage-ray-tracing "Strands of pelage as inputs of acceleration structures"
  LIBRARIES pelage_ray_tracing pelage_ray_tracing_kernels_code pelage_ray_tracing_kernels_spirv
    pelage_ray_tracing_kernels_glsl pelage_ray_tracing_kernels_essl pelage_ray_tracing_kernels REQUIRES pelage)
pelage_pkgconfig(pelage-settings "Parameters, settings files and presets for pelage"
  LIBRARIES pelage_settings REQUIRES pelage)
if(PELAGE_VULKAN)
  # The runtime opens the loader when it runs.
  pelage_pkgconfig(pelage-vulkan "Vulkan runtime of pelage"
    LIBRARIES pelage_vulkan REQUIRES pelage pelage-spirv HEADERS vulkan SYSTEM ${CMAKE_DL_LIBS})
endif()
if(PELAGE_GL)
  pelage_pkgconfig(pelage-gl "OpenGL and OpenGL ES runtime of pelage"
    LIBRARIES pelage_gl REQUIRES pelage pelage-glsl pelage-essl PRIVATE egl)
endif()
if(PELAGE_C AND PELAGE_C_SHARED)
  pelage_pkgconfig(pelage-c "C interface of pelage" LIBRARIES pelage_c)
elseif(PELAGE_C)
  set(runtimes)
  foreach(api VULKAN GL)
    if(PELAGE_${api})
      string(TOLOWER pelage-${api} package)
      list(APPEND runtimes ${package})
    endif()
  endforeach()
  pelage_pkgconfig(pelage-c "C interface of pelage"
    LIBRARIES pelage_c REQUIRES pelage-settings ${runtimes} SYSTEM stdc++ m)
endif()
if(PELAGE_MESH_IMPORT)
  pelage_pkgconfig(pelage-mesh-import "Import of skinned meshes for pelage"
    LIBRARIES pelage_mesh_import REQUIRES pelage PRIVATE assimp)
endif()
if(PELAGE_AUTHORING)
  # meshoptimizer has no pkg-config file.
  pelage_pkgconfig(pelage-authoring "Preparation of hair assets for pelage"
    LIBRARIES pelage_authoring REQUIRES pelage-mesh-import SYSTEM meshoptimizer)
endif()
