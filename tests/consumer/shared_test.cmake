# Run by ctest; see CMakeLists.txt beside this file.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# The compiled kernels are those of the build that runs this.
run(${CMAKE_COMMAND} -S ${PELAGE_SOURCE_DIR} -B ${BUILD_DIR} -G ${GENERATOR}
  -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${CXX_COMPILER_LAUNCHER}
  -D CMAKE_BUILD_TYPE=Release -D BUILD_SHARED_LIBS=ON -D PELAGE_VULKAN=OFF -D PELAGE_MESH_IMPORT=OFF
  -D PELAGE_BUILD_TESTS=OFF -D PELAGE_BUILD_SAMPLES=OFF -D PELAGE_BUILD_BENCHMARKS=OFF
  -D PELAGE_BUILD_VIEWER=OFF -D CMAKE_UNITY_BUILD=ON
  -D PELAGE_CODEGEN_EXECUTABLE=${CODEGEN} -D PELAGE_CODEGEN_CACHE=${CODEGEN_CACHE}
  -D CMAKE_SHARED_LINKER_FLAGS=-Wl,--no-undefined)
run(${CMAKE_COMMAND} --build ${BUILD_DIR})
file(REMOVE_RECURSE ${WORK_DIR}/prefix ${WORK_DIR}/consumer)
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER_SOURCE_DIR} -B ${WORK_DIR}/consumer -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_BUILD_TYPE=Release -D CONSUMER_RUNTIME=ON)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)
run(${WORK_DIR}/consumer/kernels_only)
run(${WORK_DIR}/consumer/consumer)
run(${WORK_DIR}/consumer/consumer_runtime)

# What is not marked is hidden: no internal class of the core can be seen.
file(GLOB core ${WORK_DIR}/prefix/lib*/libpelage_core.so)
execute_process(COMMAND ${NM} -DC --defined-only ${core} OUTPUT_VARIABLE symbols RESULT_VARIABLE status)
if(NOT status EQUAL 0 OR NOT symbols MATCHES "pelage::Scene::simulate")
  message(FATAL_ERROR "'${core}' does not export Scene")
endif()
if(symbols MATCHES "[^\n]*FollowContacts::[^\n]*")
  message(FATAL_ERROR "'${core}' exports ${CMAKE_MATCH_0}")
endif()
