# What nearly every source includes, compiled once for the libraries and once for the tests. Sources
# include what they use all the same: the sanitizers' presets build without these
# (CMAKE_DISABLE_PRECOMPILE_HEADERS) and so find what one has forgotten.
set(cairn_common_headers
  <algorithm> <functional> <memory> <optional> <span> <sstream> <string> <string_view>
  <unordered_map> <vector> <Eigen/Cholesky> <Eigen/Geometry> <Eigen/LU> <Eigen/QR> <Eigen/SVD>)

file(WRITE ${CMAKE_BINARY_DIR}/generated/precompiled/empty.cc "")
function(cairn_precompiled_headers target)
  add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/generated/precompiled/empty.cc)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen cairn_compiler_options)
  target_precompile_headers(${target} PRIVATE ${cairn_common_headers} ${ARGN})
endfunction()

cairn_precompiled_headers(cairn_library_headers)

if(CAIRN_BUILD_TESTS)
  cairn_precompiled_headers(cairn_test_headers
    <filesystem> <map> <random> <gmock/gmock.h> <gtest/gtest.h>)
  target_link_libraries(cairn_test_headers PRIVATE GTest::gmock)
  # Tests are executables, which the compiler tells from libraries.
  set_target_properties(cairn_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(cairn_test_headers PRIVATE -fPIE ${cairn_test_options})
endif()

# cairn_source_options(SOURCES a.cc b.cc OPTIONS -O3)
#
# Options of single sources of a folder. These do without precompiled headers, with which GCC takes
# some options, such as -fno-tree-vectorize, from the headers instead, and says nothing.
function(cairn_source_options)
  cmake_parse_arguments(ARG "" "FOLDER" "SOURCES;OPTIONS" ${ARGN})
  if(ARG_FOLDER)
    list(TRANSFORM ARG_SOURCES PREPEND ${ARG_FOLDER}/)
  endif()
  set_source_files_properties(${ARG_SOURCES} PROPERTIES
    COMPILE_OPTIONS "${ARG_OPTIONS}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()
