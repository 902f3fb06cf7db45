# Writes the file OUT, in which each suite of a gtest program is one ctest of the suite's name.
# PROGRAM: the program. LONG: as cairn_test() has it, with commas. EXCLUDED: patterns of tests that
# stay out, as --gtest_filter has them after a dash. TIMEOUT_S: how long a ctest may take. COST: that
# of LONG ones.
cmake_minimum_required(VERSION 3.23)
string(REPLACE "," ";" LONG "${LONG}")
set(script)

# Adds the ctest of some suites, with further properties. It is skipped if the end of its output says
# that no test passed and that all were skipped.
function(add_suites name suites)
  list(TRANSFORM suites APPEND ".*")
  list(JOIN suites ":" filter)
  list(JOIN ARGN " " properties)
  string(APPEND script
    "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}-${EXCLUDED}]==])\n"
    "set_tests_properties([==[${name}]==] PROPERTIES TIMEOUT ${TIMEOUT_S} ${properties}\n"
    "  SKIP_REGULAR_EXPRESSION "
    "[==[PASSED  \\] 0 tests\\.(\n\\[  SKIPPED \\] [^\n]*)+\n*$]==])\n")
  set(script "${script}" PARENT_SCOPE)
endfunction()

execute_process(COMMAND ${PROGRAM} --gtest_list_tests --gtest_filter=-${EXCLUDED}
  TIMEOUT 60 OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
# A suite's line is its name, a dot and perhaps a comment. Lines of tests are indented.
string(REGEX MATCHALL "\n[^ \n]+\\.[ \n]" suites "\n${list}")
list(TRANSFORM suites REPLACE "^\n(.+)\\.[ \n]$" "\\1")
foreach(long ${LONG})
  string(REGEX REPLACE "=.*" "" name ${long})
  string(REGEX REPLACE ".*=" "" members ${long})
  string(REPLACE ":" ";" members "${members}")
  add_suites(${name} "${members}" COST ${COST})
  foreach(member ${members})
    if(NOT member IN_LIST suites)
      message(FATAL_ERROR "cairn_test(LONG ${long}): ${PROGRAM} has no suite ${member}")
    endif()
  endforeach()
  list(REMOVE_ITEM suites ${members})
endforeach()
foreach(suite ${suites})
  add_suites(${suite} ${suite})
endforeach()
file(WRITE ${OUT} "${script}")
