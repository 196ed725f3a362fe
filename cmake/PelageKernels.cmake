# pelage_add_kernels(TARGET MANIFEST file [INCLUDE dirs...] [REFLECTION file] [SHARED] [WGSL] [MSL] [HLSL])
#
# Makes libraries, static ones without SHARED, from a manifest of HLSL kernels. Code that links
# TARGET includes
#   <namespace>/kernels.h      kernels and permutation keys
#   <namespace>/layouts.h      layout tables and Create*Layout()
#   <namespace>/gpu_structs.h  structs and constant blocks as the kernels read them
#   <namespace>/constants.h    constants that the kernels declare for the host, too
#   <namespace>/bindings.h     what a pass binds: a struct for each layout
# The code of the kernels lies in libraries of its own, one object a kernel:
#   <namespace>/spirv.h        TARGET_spirv
#   <namespace>/glsl.h         TARGET_glsl, GLSL 450 core
#   <namespace>/essl.h         TARGET_essl, ESSL 320
#   <namespace>/code.h         TARGET_code: the three of them
#   <namespace>/wgsl.h         TARGET_wgsl, with WGSL: of a manifest that has "webgpu": true. The folder wgsl
#                              beside the generated sources has the same as files. Needs
#                              PELAGE_WGSL_TRANSLATOR, codegen/wgsl/translate.mjs with its packages.
# MSL adds <namespace>/metal.h and the folder msl, HLSL adds dxc.txt: docs/metal_d3d12.md.
# The target's property PELAGE_GENERATED_INCLUDE is the folder that holds them.
# INCLUDE adds folders to the search of #include in HLSL, REFLECTION names the JSON file (default:
# reflection.json beside the generated sources).
#
# PELAGE_CODEGEN_EXECUTABLE names a pelage-codegen to use in place of the build's own or the
# package's: for cross builds, whose own does not run here. PELAGE_CODEGEN_CACHE names a folder of
# compiled permutations that several targets and build trees share. PELAGE_KERNEL_NAMES keeps names
# and lines in SPIR-V and indentation in GLSL, for debuggers; the default in Debug builds.
set(PELAGE_CODEGEN_EXECUTABLE "" CACHE FILEPATH "pelage-codegen to use (empty: the one built)")
set(PELAGE_CODEGEN_CACHE "" CACHE PATH "Folder of compiled permutations (empty: one a target)")

if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(pelage_kernel_names ON)
else()
  set(pelage_kernel_names OFF)
endif()
option(PELAGE_KERNEL_NAMES "Keep names and lines in the code of kernels" ${pelage_kernel_names})

# The names of a manifest's kernels.
function(pelage_kernel_names text out)
  set(names)
  string(JSON kernels ERROR_VARIABLE error GET "${text}" kernels)
  string(JSON count ERROR_VARIABLE error LENGTH "${kernels}")
  if(NOT error AND count GREATER 0)
    math(EXPR last "${count} - 1")
    foreach(i RANGE ${last})
      # What is wrong with the entry is said by pelage-codegen.
      string(JSON name ERROR_VARIABLE error GET "${kernels}" ${i} name)
      if(NOT error)
        list(APPEND names "${name}")
      endif()
    endforeach()
  endif()
  set(${out} "${names}" PARENT_SCOPE)
endfunction()

# The entry of one kernel of a manifest.
function(pelage_kernel_entry text name out)
  string(JSON count LENGTH "${text}" kernels)
  math(EXPR last "${count} - 1")
  foreach(i RANGE ${last})
    string(JSON entry GET "${text}" kernels ${i})
    string(JSON found GET "${entry}" name)
    if(found STREQUAL name)
      set(${out} "${entry}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "pelage has no kernel '${name}'")
endfunction()

function(pelage_add_kernels target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "SHARED;WGSL;MSL;HLSL" "MANIFEST;REFLECTION" "INCLUDE")
  if(NOT arg_MANIFEST OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR
      "usage: pelage_add_kernels(TARGET MANIFEST file [INCLUDE dirs...] [REFLECTION file] [SHARED] [WGSL] [MSL] [HLSL])")
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
  set(headers)
  set(formats spirv glsl essl)
  set(wgsl)
  if(arg_WGSL)
    if(NOT PELAGE_WGSL_TRANSLATOR)
      message(FATAL_ERROR "pelage: WGSL needs PELAGE_WGSL_TRANSLATOR")
    endif()
    list(APPEND formats wgsl)
    set(wgsl --wgsl "${PELAGE_WGSL_TRANSLATOR}" --node "${PELAGE_NODE_EXECUTABLE}")
  endif()
  set(native)
  set(native_headers)
  if(arg_MSL)
    list(APPEND native --msl)
    list(APPEND native_headers metal)
  endif()
  if(arg_HLSL)
    list(APPEND native --hlsl)
  endif()
  foreach(header bindings code constants gpu_structs kernels layouts ${native_headers} ${formats})
    list(APPEND headers "${output}/include/${folder}/${header}.h")
  endforeach()
  set(sources "${output}/kernels.cpp" "${output}/layouts.cpp")
  pelage_kernel_names("${text}" kernels)
  set(code_sources "${output}/code/code.cpp")
  set(format_sources)
  foreach(format IN LISTS formats)
    set(${format}_sources "${output}/code/${format}.cpp")
    foreach(kernel IN LISTS kernels)
      list(APPEND ${format}_sources "${output}/code/${kernel}_${format}.cpp")
    endforeach()
    list(APPEND format_sources ${${format}_sources})
  endforeach()

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
  set(names)
  if(PELAGE_KERNEL_NAMES)
    set(names --keep-names)
  endif()
  add_custom_command(
    OUTPUT "${output}/kernels.stamp"
    BYPRODUCTS ${headers} ${sources} ${code_sources} ${format_sources}
      "${reflection}"
    COMMAND ${codegen} "${manifest}" --output "${output}" ${includes} ${cache} ${names}
      ${wgsl} ${native}
      --reflection "${reflection}" --stamp "${output}/kernels.stamp" --depfile "${output}/kernels.d"
    DEPENDS ${codegen} "${manifest}" ${PELAGE_WGSL_TRANSLATOR}
    DEPFILE "${output}/kernels.d"
    COMMENT "Compiling the kernels of ${target}"
    VERBATIM)

  set(type STATIC)
  if(arg_SHARED)
    set(type SHARED)
  endif()
  # What needs the headers alone depends on this.
  add_custom_target(${target}_headers DEPENDS "${output}/kernels.stamp")
  add_library(${target} ${type} ${sources} ${headers} "${output}/kernels.stamp")
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${output}/include>)
  target_link_libraries(${target} PUBLIC pelage::headers)
  set(libraries ${target})
  foreach(format IN LISTS formats ITEMS code)
    list(APPEND libraries ${target}_${format})
    add_library(${target}_${format} ${type} ${${format}_sources} "${output}/kernels.stamp")
    target_link_libraries(${target}_${format} PUBLIC ${target})
  endforeach()
  target_link_libraries(${target}_code PUBLIC ${target}_spirv ${target}_glsl ${target}_essl)
  foreach(library IN LISTS libraries)
    add_dependencies(${library} ${target}_headers)
    target_compile_features(${library} PUBLIC cxx_std_20)
    # One object a kernel, so that a program links the code of those that it names.
    set_target_properties(${library} PROPERTIES POSITION_INDEPENDENT_CODE ON UNITY_BUILD OFF
      PELAGE_GENERATED_INCLUDE "${output}/include")
  endforeach()
endfunction()

# pelage_add_engine_lights(TARGET FILE file NAMESPACE name [TIER es|base|wide] [ROOT_UV]
#   [INCLUDE dirs...])
#
# Makes the libraries of pelage_add_kernels() from pelage's own kernels that draw strands, with the
# lights of an engine: the HLSL file defines engineLight(), which lights strands in place of pelage's
# lights in every transparency method (docs/shading.md). Its resources are in ENGINE_LIGHTS_SPACE.
# <namespace>::allKernels() goes to pelage::EngineLights::kernels. TIER is that of the devices that are
# to run them, base by default; with es, shade_strand_tiles is of base all the same. ROOT_UV: engineLight()
# reads StrandSurface.uv, which is 0 without it; lists then take 4 bytes more a node.
function(pelage_add_engine_lights target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "ROOT_UV" "FILE;NAMESPACE;TIER" "INCLUDE")
  if(NOT arg_FILE OR NOT arg_NAMESPACE OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "usage: pelage_add_engine_lights(TARGET FILE file NAMESPACE name "
      "[TIER es|base|wide] [ROOT_UV] [INCLUDE dirs...])")
  endif()
  if(NOT arg_TIER)
    set(arg_TIER base)
  endif()
  set(kernels "${PELAGE_KERNELS_DIR}")
  if(NOT kernels)
    set(kernels "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../kernels")
  endif()
  get_filename_component(kernels "${kernels}" ABSOLUTE)
  get_filename_component(lights "${arg_FILE}" ABSOLUTE)
  get_filename_component(lights_dir "${lights}" DIRECTORY)
  get_filename_component(lights_name "${lights}" NAME)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${kernels}/manifest.json")
  file(READ "${kernels}/manifest.json" own)

  # Of each kernel: the name of a group with the engine's layout behind pelage's; none: the vertex
  # stages, which draw with any of them.
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${target}_source")
  set(manifest "{\"groups\": {}, \"kernels\": []}")
  string(JSON manifest SET "${manifest}" namespace "\"${arg_NAMESPACE}\"")
  set(defines)
  set(uv_kernels)
  if(arg_ROOT_UV)
    set(defines "#define STRAND_UV 1\n")
    set(uv_kernels ppll_build:)
  endif()
  foreach(entry strand_vertex: strand_record_vertex: oit_tile_vertex: strand_pixel:StrandPixel
      ppll_read:PpllRead hybrid_colors:HybridColors short_cut_fill_colors:ShortCutFillColors
      shade_strand_tiles:ShadeStrandTiles ${uv_kernels})
    string(REGEX MATCH "^([^:]*):(.*)$" matched "${entry}")
    set(name "${CMAKE_MATCH_1}")
    set(lit "${CMAKE_MATCH_2}")
    pelage_kernel_entry("${own}" "${name}" kernel)
    string(JSON file GET "${kernel}" file)
    string(JSON group GET "${kernel}" group)
    string(JSON layouts GET "${own}" groups "${group}")
    set(text "// Made by pelage_add_engine_lights() for ${target}. Edits are lost.\n${defines}")
    if(lit)
      set(group "lit${lit}")
      string(JSON space LENGTH "${layouts}")
      string(JSON layouts SET "${layouts}" ${space} "\"${lit}Lights\"")
      string(JSON kernel SET "${kernel}" group "\"${group}\"")
      if(NOT arg_TIER STREQUAL "es")
        string(JSON kernel SET "${kernel}" tier "\"${arg_TIER}\"")
      endif()
      string(APPEND text "#define ENGINE_LIGHTS_SPACE space${space}\n"
        "#include \"${file}\"\n#include \"${lights_name}\"\n")
    else()
      string(APPEND text "#include \"${file}\"\n")
    endif()
    string(JSON kernel SET "${kernel}" file "\"${name}.hlsl\"")
    string(JSON manifest SET "${manifest}" groups "${group}" "${layouts}")
    string(JSON count LENGTH "${manifest}" kernels)
    string(JSON manifest SET "${manifest}" kernels ${count} "${kernel}")
    file(CONFIGURE OUTPUT "${folder}/${name}.hlsl" CONTENT "${text}" @ONLY)
  endforeach()
  file(CONFIGURE OUTPUT "${folder}/manifest.json" CONTENT "${manifest}\n" @ONLY)
  pelage_add_kernels(${target} MANIFEST "${folder}/manifest.json"
    INCLUDE "${kernels}" "${lights_dir}" ${arg_INCLUDE})
endfunction()
