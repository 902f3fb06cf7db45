# Packs the build tree and inspects the Debian packages:
# cmake -DBUILD_DIR=... -DSCRATCH_DIR=... -P run_package_test.cmake
function(run output)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

function(expect text part)
  if(NOT text MATCHES "${part}")
    message(FATAL_ERROR "expected '${part}' in:\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${SCRATCH_DIR})
# gzip takes a fraction of the time of xz, and the packages are only looked at.
run(ignored ${CMAKE_CPACK_COMMAND} --config ${BUILD_DIR}/CPackConfig.cmake -G DEB -B ${SCRATCH_DIR}
  -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip)
file(GLOB runtime ${SCRATCH_DIR}/cairn_*.deb)
file(GLOB development ${SCRATCH_DIR}/libcairn-dev_*.deb)
file(GLOB fusion ${SCRATCH_DIR}/libcairn-fusion-dev_*.deb)
file(GLOB lab ${SCRATCH_DIR}/cairn-lab_*.deb)

run(info dpkg-deb --info ${runtime})
expect("${info}" "Depends: [^\n]*libsqlite3-0")
expect("${info}" "Depends: [^\n]*adduser")
expect("${info}" "postinst")
if(info MATCHES "imgcodecs|libatlas")
  message(FATAL_ERROR "the server needs no such library:\n${info}")
endif()
run(contents dpkg-deb --contents ${runtime})
foreach(file /usr/bin/cairn /systemd/system/cairn@.service /usr/share/man/man1/cairn-localize.1.gz
    /usr/share/bash-completion/completions/cairn /usr/share/doc/cairn/copyright)
  expect("${contents}" "${file}")
endforeach()

run(contents dpkg-deb --contents ${development})
expect("${contents}" "/usr/include/cairn/engine/localizer.h")
expect("${contents}" "/pkgconfig/cairn.pc")
run(info dpkg-deb --info ${fusion})
foreach(package nlohmann-json3-dev libcpp-httplib-dev libssl-dev)  # cairn-fusion.pc requires them.
  expect("${info}" "Depends: [^\n]*${package}")
endforeach()
run(contents dpkg-deb --contents ${fusion})
expect("${contents}" "/cmake/cairn/cairnConfig.cmake")
expect("${contents}" "/usr/include/cairn/fusion/client/fusion_client.h")
file(GLOB python ${SCRATCH_DIR}/python3-cairn_*.deb)
if(python)  # Not built without pybind11.
  run(info dpkg-deb --info ${python})
  expect("${info}" "Depends: [^\n]*libsqlite3-0")
  expect("${info}" "Depends: [^\n]*python3-numpy")
  run(contents dpkg-deb --contents ${python})
  expect("${contents}" "/usr/lib/python3/dist-packages/cairn/__init__.py")
  expect("${contents}" "/usr/lib/python3/dist-packages/cairn/_cairn.*[.]so")
endif()
run(contents dpkg-deb --contents ${lab})
expect("${contents}" "/usr/bin/cairn-lab")
expect("${contents}" "/usr/share/man/man1/cairn-lab-bench.1.gz")

find_program(LINTIAN lintian)
if(LINTIAN)
  # As root of a container, too; that is not what it checks.
  execute_process(COMMAND ${LINTIAN} --allow-root --tag-display-limit 0 --fail-on error
    ${runtime} ${development} ${fusion} ${lab} ${python} RESULT_VARIABLE failed OUTPUT_VARIABLE text)
  if(failed)
    message(FATAL_ERROR "lintian:\n${text}")
  endif()
endif()
file(REMOVE_RECURSE ${SCRATCH_DIR})
