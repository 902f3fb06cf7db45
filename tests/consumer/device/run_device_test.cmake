# Installs the component `fusion` alone into a scratch prefix, then configures, builds and runs the
# device against it: cmake -DBUILD_DIR=... -DSOURCE_DIR=... -DSCRATCH_DIR=... -P run_device_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${SCRATCH_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${SCRATCH_DIR}/prefix --component fusion)
file(GLOB_RECURSE of_servers ${SCRATCH_DIR}/prefix/*engine* ${SCRATCH_DIR}/prefix/*storage*
  ${SCRATCH_DIR}/prefix/*libcairn_core_adjust* ${SCRATCH_DIR}/prefix/*rival*)
if(of_servers)
  message(FATAL_ERROR "of no use to a device: ${of_servers}")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${SCRATCH_DIR}/build -G ${GENERATOR}
  -DCMAKE_PREFIX_PATH=${SCRATCH_DIR}/prefix -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/build)
run(${SCRATCH_DIR}/build/device)
file(REMOVE_RECURSE ${SCRATCH_DIR})
