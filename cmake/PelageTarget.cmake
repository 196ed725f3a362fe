# pelage_target(TARGET): the settings that every target of this project shares.
function(pelage_target target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(MSVC)
    target_compile_options(${target} PRIVATE /W4 $<$<BOOL:${PELAGE_WARNINGS_AS_ERRORS}>:/WX>)
  else()
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
      -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual
      $<$<BOOL:${PELAGE_WARNINGS_AS_ERRORS}>:-Werror>)
    # GCC 12 warns about its own std::string in "literal" + string (PR 105651, PR 105329).
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow
        -Wno-stringop-overread -Wno-array-bounds)
    endif()
    # The same numbers in every build: no contraction of a*b+c on the host.
    target_compile_options(${target} PRIVATE -ffp-contract=off)
  endif()
  if(PELAGE_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=address,undefined
      -fno-sanitize=vptr  # Debian builds glslang without run-time type information
      # What the address sanitizer finds as well; it makes compiling much longer.
      -fno-sanitize=null,object-size,pointer-overflow
      # The fuzzers look for it in the loaders, which are the code that casts bytes.
      -fno-sanitize=alignment
      -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
    # GCC warns about std::regex and std::function when it instruments them (PR 105562).
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
    endif()
  endif()
endfunction()

# pelage_thin_target(TARGET): one whose own code takes no time that counts: command lines, windows, files of
# text. The compiler spends less on it.
function(pelage_thin_target target)
  pelage_target(${target})
  target_compile_options(${target} PRIVATE
    $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-O1>
    $<$<AND:$<CONFIG:Debug>,$<CXX_COMPILER_ID:GNU,Clang>>:-O0>)  # the sanitizers' preset has -O1
endfunction()

# pelage_library(TARGET): one of the libraries that PELAGE_SHARED makes shared. They export what
# pelage/export.h marks, and find each other in the folder where they are installed.
set(pelage_library_type STATIC)
if(PELAGE_SHARED)
  set(pelage_library_type SHARED)
endif()
function(pelage_library target)
  if(NOT PELAGE_SHARED)
    return()
  endif()
  target_compile_definitions(${target} PUBLIC PELAGE_SHARED)
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH "$ORIGIN")
endfunction()

# pelage_precompile(TARGET [HEADERS...]): precompiles the standard headers that most files include, and
# these, for the files of a target. Every file still includes what it uses; `test_all.sh sources` compiles
# them one by one without.
option(PELAGE_PRECOMPILED_HEADERS "Precompile the headers that most files include"
  ${PROJECT_IS_TOP_LEVEL})
function(pelage_precompile target)
  if(NOT PELAGE_PRECOMPILED_HEADERS)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <cstring>
    <filesystem> <functional> <limits> <map> <memory> <optional> <span> <string> <string_view>
    <unordered_map> <utility> <variant> <vector> ${ARGN})
endfunction()
