# Installs the build tree into a scratch prefix, then configures, builds and runs the consumer
# against it: cmake -DBUILD_DIR=... -DSOURCE_DIR=... -DSCRATCH_DIR=... -P run_consumer_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${SCRATCH_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${SCRATCH_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${SCRATCH_DIR}/build -G ${GENERATOR}
  -DCMAKE_PREFIX_PATH=${SCRATCH_DIR}/prefix -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/build)
run(${SCRATCH_DIR}/build/consumer ${SCRATCH_DIR}/empty.gpkg)
# The same program without CMake.
run(sh -c "PKG_CONFIG_PATH=$(dirname $(find '${SCRATCH_DIR}/prefix' -name cairn.pc)) && \
  export PKG_CONFIG_PATH && ${CXX} -std=c++20 -O1 '${SOURCE_DIR}/main.cc' -o '${SCRATCH_DIR}/plain' \
  $(pkg-config --cflags --libs cairn)")
run(${SCRATCH_DIR}/plain ${SCRATCH_DIR}/plain.gpkg)
run(${SCRATCH_DIR}/prefix/bin/cairn info ${SCRATCH_DIR}/empty.gpkg)
file(REMOVE_RECURSE ${SCRATCH_DIR})
