# cairn_library(NAME storage SOURCES a.cc b.cc PUBLIC dep... PRIVATE dep...)
#
# The static library of a room, `cairn_NAME`. Its headers are visible to others only through the
# target: each room has an include root of its own that holds nothing but a link to its folder, so an
# #include against the arrows of docs/architecture.md does not compile.
# ROOM names the room when it has several targets (default: NAME). FOLDER: where in the room the
# sources are (default: its root). APART: sources that use the same names as others of the folder for
# parts that correspond. The release preset compiles each of them alone, and the others of the folder
# together.
function(cairn_library)
  cmake_parse_arguments(ARG "" "NAME;ROOM;FOLDER" "SOURCES;APART;PUBLIC;PRIVATE" ${ARGN})
  if(NOT ARG_ROOM)
    set(ARG_ROOM ${ARG_NAME})
  endif()
  if(ARG_FOLDER)
    list(TRANSFORM ARG_SOURCES PREPEND ${ARG_FOLDER}/)
    list(TRANSFORM ARG_APART PREPEND ${ARG_FOLDER}/)
  endif()
  set(target cairn_${ARG_NAME})
  set(include_root ${CMAKE_BINARY_DIR}/include/${ARG_ROOM})
  file(MAKE_DIRECTORY ${include_root})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${ARG_ROOM} ${include_root}/${ARG_ROOM} SYMBOLIC)

  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(cairn::${ARG_NAME} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${ARG_NAME})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${include_root}> $<INSTALL_INTERFACE:include>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:cairn_compiler_options>)
  if(NOT OpenMP::OpenMP_CXX IN_LIST ARG_PRIVATE)  # Whose flag the precompiled headers lack.
    target_precompile_headers(${target} REUSE_FROM cairn_library_headers)
  endif()
  set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set_property(GLOBAL APPEND PROPERTY CAIRN_LIBRARIES ${target})
endfunction()

# ctest starts tests of higher cost first. A test without a cost has the seconds of its earlier runs.
# These costs are above all of those, so that no long test runs alone at the end, also in a new build.
set(cairn_cost_of_long_tests 1000)
set(cairn_cost_of_wide_tests 2000)  # Of tests that need two processors.

# cairn_test(NAME storage SOURCES a_test.cc DEPENDS cairn::storage LONG Suite...)
#
# One test binary a room, `cairn_NAME_test`. Each suite in it is one ctest, `Suite`, because a process
# takes longer to start than most tests do, and because tests of a suite often share what is costly to
# make. So no test may depend on what another one left. Tests may include anything their DEPENDS
# offer, and tests/support/. LONG: suites that start before others. `Base=Suite:Suite` makes one
# ctest, `Base`, of several suites that share a base class and what it made. ON_SERVER: tests whose
# names end in /OnServer are one ctest, because each process that uses PostgreSQL starts a server of
# its own.
function(cairn_test)
  cmake_parse_arguments(ARG "ON_SERVER" "NAME;TIMEOUT" "SOURCES;DEPENDS;LONG" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "cairn_test(${ARG_NAME}): unknown ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 1200)
  endif()
  set(target cairn_${ARG_NAME}_test)
  add_executable(${target} ${ARG_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(${target} PRIVATE ${cairn_test_options})
  target_compile_definitions(${target} PRIVATE
    CAIRN_SOURCE_DIR="${PROJECT_SOURCE_DIR}" CAIRN_BINARY_DIR="${CMAKE_BINARY_DIR}")
  target_link_libraries(${target} PRIVATE
    ${ARG_DEPENDS} GTest::gmock GTest::gtest_main cairn_compiler_options)
  if(NOT OpenMP::OpenMP_CXX IN_LIST ARG_DEPENDS)
    target_precompile_headers(${target} REUSE_FROM cairn_test_headers)
  endif()
  set(excluded)
  if(ARG_ON_SERVER AND CAIRN_WITH_POSTGRES)
    set(excluded */OnServer)
    add_test(NAME ${target}.OnServer COMMAND ${target} --gtest_filter=${excluded})
    set_tests_properties(${target}.OnServer PROPERTIES TIMEOUT 1800 COST ${cairn_cost_of_long_tests})
  endif()
  list(JOIN ARG_LONG "," long)
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  set_property(TARGET ${target} APPEND PROPERTY
    LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/DiscoverSuites.cmake)
  add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS ${suites}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DLONG=${long}
      -DEXCLUDED=${excluded} -DTIMEOUT_S=${ARG_TIMEOUT} -DCOST=${cairn_cost_of_long_tests}
      -DOUT=${suites} -P ${PROJECT_SOURCE_DIR}/cmake/DiscoverSuites.cmake
    VERBATIM)
  file(CONFIGURE OUTPUT ${target}_discovery.cmake @ONLY CONTENT [=[
if(EXISTS [==[@suites@]==])
  include([==[@suites@]==])
else()
  add_test(@target@_is_not_built @target@_is_not_built)
endif()
]=])
  set_property(DIRECTORY APPEND PROPERTY
    TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${target}_discovery.cmake)
endfunction()

# cairn_fuzz_target(NAME base64 DEPENDS cairn::http)
#
# A decoder under test, from base64_fuzz.cc; tests/fuzz/fuzz_target.h says what such a file has. With
# CAIRN_FUZZ it is a program, `cairn_base64_fuzz`, which libFuzzer drives (scripts/fuzz). Without, the
# test Fuzz.base64 replays the inputs in corpus/base64/, by the program of cairn_fuzz_replay().
function(cairn_fuzz_target)
  cmake_parse_arguments(ARG "" "NAME" "DEPENDS" ${ARGN})
  if(NOT CAIRN_FUZZ)
    set_property(GLOBAL APPEND PROPERTY CAIRN_FUZZ_NAMES ${ARG_NAME})
    set_property(GLOBAL APPEND PROPERTY CAIRN_FUZZ_DEPENDS ${ARG_DEPENDS})
    add_test(NAME Fuzz.${ARG_NAME}
      COMMAND cairn_fuzz_replay ${ARG_NAME} ${CMAKE_CURRENT_SOURCE_DIR}/corpus/${ARG_NAME})
    return()
  endif()
  set(target cairn_${ARG_NAME}_fuzz)
  add_executable(${target} ${ARG_NAME}_fuzz.cc)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${target} PRIVATE ${ARG_DEPENDS} fmt::fmt cairn_compiler_options)
  target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  add_dependencies(cairn_fuzz_targets ${target})
endfunction()

# cairn_fuzz_replay()
#
# `cairn_fuzz_replay NAME FOLDER` runs a target of cairn_fuzz_target() on the files of a folder. Each
# target has the name of its function there. In a unity build all of them are one source, because
# each would read the same headers again.
function(cairn_fuzz_replay)
  get_property(names GLOBAL PROPERTY CAIRN_FUZZ_NAMES)
  get_property(depends GLOBAL PROPERTY CAIRN_FUZZ_DEPENDS)
  list(REMOVE_DUPLICATES depends)
  set(CAIRN_FUZZ_TARGETS)
  set(CAIRN_FUZZ_TABLE)
  set(source ${CMAKE_BINARY_DIR}/generated/fuzz/fuzz_targets.cc)
  set(sources replay_main.cc ${source})
  foreach(name ${names})
    string(APPEND CAIRN_FUZZ_TABLE "    {\"${name}\", Fuzz_${name}},\n")
    if(CMAKE_UNITY_BUILD)
      string(APPEND CAIRN_FUZZ_TARGETS
        "#define LLVMFuzzerTestOneInput Fuzz_${name}\n"
        "#include \"fuzz/${name}_fuzz.cc\"\n"
        "#undef LLVMFuzzerTestOneInput\n")
    else()
      string(APPEND CAIRN_FUZZ_TARGETS
        "extern \"C\" int Fuzz_${name}(const uint8_t* data, size_t size);\n")
      list(APPEND sources ${name}_fuzz.cc)
      set_source_files_properties(${name}_fuzz.cc PROPERTIES
        COMPILE_DEFINITIONS LLVMFuzzerTestOneInput=Fuzz_${name})
    endif()
  endforeach()
  configure_file(fuzz_targets.cc.in ${source} @ONLY)
  add_executable(cairn_fuzz_replay ${sources})
  set_target_properties(cairn_fuzz_replay PROPERTIES UNITY_BUILD OFF)
  target_include_directories(cairn_fuzz_replay PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(cairn_fuzz_replay PRIVATE ${cairn_test_options})
  target_link_libraries(cairn_fuzz_replay PRIVATE ${depends} fmt::fmt cairn_compiler_options)
endfunction()

# cairn_benchmark(NAME matching SOURCES x_bench.cc DEPENDS cairn::engine)
function(cairn_benchmark)
  if(NOT CAIRN_BUILD_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;DEPENDS" ${ARGN})
  set(target cairn_${ARG_NAME}_bench)
  add_executable(${target} ${ARG_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${target} PRIVATE
    ${ARG_DEPENDS} benchmark::benchmark_main cairn_compiler_options)
endfunction()

# cairn_embed(TARGET cairn_sql HEADER sql/schema.h NAMESPACE cairn::sql FILES a.sql b.sql)
#
# Makes each file a `std::string_view k_<name>` (dots and dashes become underscores) in a generated
# header that the target exports.
function(cairn_embed)
  cmake_parse_arguments(ARG "" "TARGET;HEADER;NAMESPACE" "FILES" ${ARGN})
  set(out ${CMAKE_BINARY_DIR}/generated/${ARG_TARGET}/${ARG_HEADER})
  set(files)
  foreach(file ${ARG_FILES})
    list(APPEND files ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  string(REPLACE ";" "," file_list "${files}")
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DOUT=${out} -DNAMESPACE=${ARG_NAMESPACE} -DFILES=${file_list}
            -P ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake
    DEPENDS ${files} ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake
    COMMENT "Embedding ${ARG_HEADER}" VERBATIM)
  add_custom_target(${ARG_TARGET}_generate DEPENDS ${out})
  add_library(${ARG_TARGET} INTERFACE)
  add_dependencies(${ARG_TARGET} ${ARG_TARGET}_generate)
  target_include_directories(${ARG_TARGET} INTERFACE
    $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/generated/${ARG_TARGET}>)
endfunction()

# cairn_manual(cairn)
#
# Man pages and bash completion of a program, which writes them itself (cli/help_command.h), in
# ${PROJECT_BINARY_DIR}/manual/<program>/, each time it is linked. CairnInstall.cmake installs them.
find_program(GZIP_PROGRAM gzip)
function(cairn_manual program)
  set(folder ${PROJECT_BINARY_DIR}/manual/${program})
  set(compress)
  if(GZIP_PROGRAM)  # As man pages are installed. -n: without the time, so that builds are equal.
    set(compress COMMAND ${GZIP_PROGRAM} -9 -n -r ${folder}/man1)
  endif()
  add_custom_command(TARGET ${program} POST_BUILD
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${folder}
    COMMAND ${program} write-manual ${folder}
    ${compress}
    VERBATIM)
endfunction()

# cairn_require_built(runtime cairn cairn_sqlite)
#
# A build that made only some targets, as scripts/demo does, installs the components that it has. The
# others say what builds them. Call this before the first install() of the component.
function(cairn_require_built component)
  set(files)
  foreach(target ${ARGN})
    list(APPEND files "$<TARGET_FILE:${target}>")
  endforeach()
  list(JOIN files "\" \"" files)  # Folders may have a space in their name.
  install(CODE "
    foreach(file \"${files}\")
      if(NOT EXISTS \"\${file}\")
        message(FATAL_ERROR \"\${file} is not built. 'scripts/build release' builds all; after \"
          \"scripts/demo, 'cmake --install ${PROJECT_BINARY_DIR} --component runtime' installs the \"
          \"program alone.\")
      endif()
    endforeach()" COMPONENT ${component})
endfunction()
