# Run by ctest; see CMakeLists.txt beside this file.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# The compiled kernels are those of the build that runs this.
function(configure folder)
  run(${CMAKE_COMMAND} -S ${SOURCE_DIR}/subdirectory -B ${WORK_DIR}/${folder} -G ${GENERATOR}
    -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${CXX_COMPILER_LAUNCHER}
    -D CMAKE_BUILD_TYPE=Release -D CMAKE_INSTALL_PREFIX=${WORK_DIR}/${folder}_prefix
    -D FETCHCONTENT_SOURCE_DIR_PELAGE=${PELAGE_SOURCE_DIR}
    -D PELAGE_VULKAN=${VULKAN} -D PELAGE_GL=${GL} -D PELAGE_MESH_IMPORT=${MESH_IMPORT}
    -D PELAGE_CODEGEN_EXECUTABLE=${CODEGEN} -D PELAGE_CODEGEN_CACHE=${CODEGEN_CACHE} ${ARGN})
  # The project's own installation and tests stay empty.
  run(${CMAKE_COMMAND} --install ${WORK_DIR}/${folder})
  file(GLOB_RECURSE installed ${WORK_DIR}/${folder}_prefix/*)
  if(installed)
    message(FATAL_ERROR "the project installs files of pelage: ${installed}")
  endif()
  file(GLOB_RECURSE tests ${WORK_DIR}/${folder}/CTestTestfile.cmake)
  foreach(file IN LISTS tests)
    file(STRINGS ${file} lines REGEX "^add_test")
    if(lines)
      message(FATAL_ERROR "the project has tests of pelage: ${lines}")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
configure(subdirectory -D CONSUMER_ADD_SUBDIRECTORY=ON)
configure(fetched)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/fetched --target kernels_only)
run(${WORK_DIR}/fetched/kernels_only)
