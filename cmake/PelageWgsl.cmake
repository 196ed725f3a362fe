# PELAGE_WGSL: pelage::wgsl, the kernels as WGSL. naga, which translates, is a package of npm: Node.js 18 or
# later and npm are needed where this is on, and the registry (or npm's cache) when the tree is first
# configured. Without them everything else is built.
#
# Sets PELAGE_WGSL_TRANSLATOR and PELAGE_NODE_EXECUTABLE, which pelage_add_kernels(... WGSL) reads.
option(PELAGE_WGSL "Build the kernels as WGSL, for WebGPU (pelage::wgsl; needs Node.js and npm)" OFF)
set(PELAGE_WGSL_TRANSLATOR "")
set(PELAGE_HAS_WGSL OFF)
if(NOT PELAGE_WGSL)
  return()
endif()

find_program(PELAGE_NODE_EXECUTABLE NAMES node nodejs)
find_program(PELAGE_NPM_EXECUTABLE NAMES npm)
mark_as_advanced(PELAGE_NODE_EXECUTABLE PELAGE_NPM_EXECUTABLE)
if(NOT PELAGE_NODE_EXECUTABLE OR NOT PELAGE_NPM_EXECUTABLE)
  message(WARNING "pelage: no WGSL: there is no Node.js with npm (Debian: nodejs, npm)")
  return()
endif()

# The packages are installed in the build tree, and again when their list changes.
set(pelage_wgsl_source ${CMAKE_CURRENT_LIST_DIR}/../codegen/wgsl)
set(pelage_wgsl_dir ${PROJECT_BINARY_DIR}/wgsl)
foreach(file package.json package-lock.json translate.mjs uniform.mjs)
  configure_file(${pelage_wgsl_source}/${file} ${pelage_wgsl_dir}/${file} COPYONLY)
endforeach()
file(SHA256 ${pelage_wgsl_dir}/package-lock.json pelage_wgsl_wanted)
if(NOT pelage_wgsl_wanted STREQUAL "${PELAGE_WGSL_PACKAGES}")
  execute_process(
    COMMAND ${PELAGE_NPM_EXECUTABLE} ci --ignore-scripts --no-audit --no-fund
    WORKING_DIRECTORY ${pelage_wgsl_dir}
    RESULT_VARIABLE pelage_wgsl_failed OUTPUT_QUIET ERROR_VARIABLE pelage_wgsl_said)
  if(pelage_wgsl_failed)
    message(WARNING "pelage: no WGSL: npm cannot install naga-wasm: ${pelage_wgsl_said}")
    return()
  endif()
  set(PELAGE_WGSL_PACKAGES ${pelage_wgsl_wanted} CACHE INTERNAL "Packages of pelage_wgsl_dir")
endif()
set(PELAGE_WGSL_TRANSLATOR ${pelage_wgsl_dir}/translate.mjs)
set(PELAGE_HAS_WGSL ON)
