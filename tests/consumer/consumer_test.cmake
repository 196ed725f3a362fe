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
# What print_asset and print_frame print is on the page, as it is.
file(READ ${tutorial} page)
foreach(program ${PROGRAMS})
  execute_process(COMMAND ${CONSUMER_WORK_DIR}/build/${program}
    OUTPUT_VARIABLE output RESULT_VARIABLE status)
  message("${output}")
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed with ${status}: ${program}")
  endif()
  if(program MATCHES "^print_")
    string(REGEX REPLACE "\n$" "" lines "${output}")
    string(REPLACE "\n" ";" lines "${lines}")
    foreach(line ${lines})
      string(FIND "${page}" "\n    ${line}\n" found)
      if(found EQUAL -1)
        message(FATAL_ERROR "docs/tutorial.md does not have what ${program} prints: ${line}")
      endif()
    endforeach()
  endif()
endforeach()
