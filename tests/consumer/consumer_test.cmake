# Run by ctest; see CMakeLists.txt beside this file.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed with ${status}: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${CONSUMER_WORK_DIR})
run(${CMAKE_COMMAND} --install ${PELAGE_BINARY_DIR} --prefix ${CONSUMER_WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER_SOURCE_DIR} -B ${CONSUMER_WORK_DIR}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${CONSUMER_WORK_DIR}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${CONSUMER_WORK_DIR}/build)
run(${CONSUMER_WORK_DIR}/build/consumer)
