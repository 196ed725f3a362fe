# Run by ctest; see CMakeLists.txt beside this file.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${CONSUMER_WORK_DIR})
run(${CMAKE_COMMAND} --install ${PELAGE_BINARY_DIR} --prefix ${CONSUMER_WORK_DIR}/prefix)
file(GLOB_RECURSE tutorial ${CONSUMER_WORK_DIR}/prefix/*/doc/pelage/docs/tutorial.md)
if(NOT tutorial)
  message(FATAL_ERROR "the package has no documentation")
endif()
run(${CMAKE_COMMAND} -S ${CONSUMER_SOURCE_DIR} -B ${CONSUMER_WORK_DIR}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${CONSUMER_WORK_DIR}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${CONSUMER_WORK_DIR}/build)
# A program carries the code of the kernels that it names: kernels_only names one, in one format.
if(kernels_only IN_LIST PROGRAMS)
  execute_process(COMMAND ${NM} -C --defined-only ${CONSUMER_WORK_DIR}/build/kernels_only
    OUTPUT_VARIABLE symbols RESULT_VARIABLE status)
  string(REGEX MATCHALL "pelage::k[A-Za-z]+(Spirv|Glsl|Essl)\n" tables "${symbols}")
  if(NOT status EQUAL 0 OR NOT tables STREQUAL "pelage::kShiftPositionsSpirv\n")
    message(FATAL_ERROR "kernels_only carries other code than it names: ${status} ${tables}")
  endif()
endif()
foreach(program ${PROGRAMS})
  run(${CONSUMER_WORK_DIR}/build/${program})
endforeach()
