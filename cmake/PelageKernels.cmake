# pelage_add_kernels(TARGET MANIFEST file [INCLUDE dirs...] [REFLECTION file])
#
# Makes the static library TARGET from a manifest of HLSL kernels. Code that links it includes
#   <namespace>/kernels.h      kernels, permutation keys, embedded SPIR-V and GLSL
#   <namespace>/layouts.h      layout tables and Create*Layout()
#   <namespace>/gpu_structs.h  structs and constant blocks as the kernels read them
# The target's property PELAGE_GENERATED_INCLUDE is the folder that holds them.
# INCLUDE adds folders to the search of #include in HLSL, REFLECTION names the JSON file (default:
# reflection.json beside the generated sources).
#
# PELAGE_CODEGEN_EXECUTABLE names a pelage-codegen to use in place of the build's own or the
# package's: for cross builds, whose own does not run here. PELAGE_CODEGEN_CACHE names a folder of
# compiled permutations that several targets and build trees share.
set(PELAGE_CODEGEN_EXECUTABLE "" CACHE FILEPATH "pelage-codegen to use (empty: the one built)")
set(PELAGE_CODEGEN_CACHE "" CACHE PATH "Folder of compiled permutations (empty: one a target)")

function(pelage_add_kernels target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "MANIFEST;REFLECTION" "INCLUDE")
  if(NOT arg_MANIFEST OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR
      "usage: pelage_add_kernels(TARGET MANIFEST file [INCLUDE dirs...] [REFLECTION file])")
  endif()
  get_filename_component(manifest "${arg_MANIFEST}" ABSOLUTE)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/${target}")
  set(reflection "${output}/reflection.json")
  if(arg_REFLECTION)
    get_filename_component(reflection "${arg_REFLECTION}" ABSOLUTE
      BASE_DIR "${CMAKE_CURRENT_BINARY_DIR}")
  endif()

  # The namespace decides where the headers go; a changed manifest configures again.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${manifest}")
  file(READ "${manifest}" text)
  string(JSON namespace ERROR_VARIABLE error GET "${text}" namespace)
  if(error)
    message(FATAL_ERROR "${manifest}:1: error: [PK301] ${error}")
  endif()
  string(REPLACE "::" "/" folder "${namespace}")
  set(headers
    "${output}/include/${folder}/gpu_structs.h"
    "${output}/include/${folder}/kernels.h"
    "${output}/include/${folder}/layouts.h")
  set(sources "${output}/kernels.cpp" "${output}/layouts.cpp")

  set(includes)
  foreach(dir IN LISTS arg_INCLUDE)
    get_filename_component(dir "${dir}" ABSOLUTE)
    list(APPEND includes "-I${dir}")
  endforeach()
  set(codegen pelage::codegen)
  if(PELAGE_CODEGEN_EXECUTABLE)
    set(codegen "${PELAGE_CODEGEN_EXECUTABLE}")
  endif()
  set(cache)
  if(PELAGE_CODEGEN_CACHE)
    set(cache --cache "${PELAGE_CODEGEN_CACHE}")
  endif()
  add_custom_command(
    OUTPUT "${output}/kernels.stamp"
    BYPRODUCTS ${headers} ${sources} "${reflection}"
    COMMAND ${codegen} "${manifest}" --output "${output}" ${includes} ${cache}
      --reflection "${reflection}" --stamp "${output}/kernels.stamp" --depfile "${output}/kernels.d"
    DEPENDS ${codegen} "${manifest}"
    DEPFILE "${output}/kernels.d"
    COMMENT "Compiling the kernels of ${target}"
    VERBATIM)

  add_library(${target} STATIC ${sources} ${headers} "${output}/kernels.stamp")
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
    PELAGE_GENERATED_INCLUDE "${output}/include")
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${output}/include>)
  target_link_libraries(${target} PUBLIC pelage::headers)
endfunction()
