# What makes builds of this project faster where it is installed: a compiler cache and a linker. A project
# that takes pelage with add_subdirectory() chooses its own.
if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

find_program(PELAGE_CCACHE ccache)
mark_as_advanced(PELAGE_CCACHE)
if(PELAGE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Precompiled headers also need CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,
  # include_file_ctime in the environment (ccache's manual, "Precompiled headers"); scripts/ set it.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${PELAGE_CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-fpch-preprocess)
  endif()
endif()

find_program(PELAGE_LINKER NAMES mold ld.lld)
mark_as_advanced(PELAGE_LINKER)
if(PELAGE_LINKER AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang" AND
   NOT "$ENV{LDFLAGS} ${CMAKE_EXE_LINKER_FLAGS}" MATCHES "-fuse-ld")
  if(PELAGE_LINKER MATCHES "mold$")
    add_link_options(-fuse-ld=mold)
  else()
    add_link_options(-fuse-ld=lld)
  endif()
endif()
