# Run by scripts/test_all.sh: programs against the shared libraries of the build BUILD_DIR, installed.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
set(WORK_DIR ${BUILD_DIR}/consumer_test)

file(REMOVE_RECURSE ${WORK_DIR}/prefix ${WORK_DIR}/consumer)
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/project -B ${WORK_DIR}/consumer -G Ninja
  -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix -D CMAKE_BUILD_TYPE=Release -D CONSUMER_RUNTIME=ON)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)
run(${WORK_DIR}/consumer/kernels_only)
run(${WORK_DIR}/consumer/consumer)
run(${WORK_DIR}/consumer/consumer_runtime)

# What is not marked is hidden: no internal class of the core can be seen.
file(GLOB core ${WORK_DIR}/prefix/lib*/libpelage_core.so)
execute_process(COMMAND nm -DC --defined-only ${core} OUTPUT_VARIABLE symbols RESULT_VARIABLE status)
if(NOT status EQUAL 0 OR NOT symbols MATCHES "pelage::Scene::simulate")
  message(FATAL_ERROR "'${core}' does not export Scene")
endif()
if(symbols MATCHES "[^\n]*FollowContacts::[^\n]*")
  message(FATAL_ERROR "'${core}' exports ${CMAKE_MATCH_0}")
endif()
