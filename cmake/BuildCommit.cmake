# Writes a source with the commit of the checkout and its date. Rewrites it only if they have changed.
# What `git archive` packs has them in cmake/archived_commit.txt instead.
set(commit "")
set(date "")
execute_process(COMMAND git -C ${SOURCE_DIR} rev-parse --show-toplevel
  OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(REAL_PATH ${SOURCE_DIR} root)
if(top STREQUAL root)  # Not the checkout of another project that holds an unpacked archive.
  execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=10 --exclude=*
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND git -C ${SOURCE_DIR} log -1 --format=%cs
    OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
else()
  file(STRINGS ${SOURCE_DIR}/cmake/archived_commit.txt archived LIMIT_COUNT 1)
  if(archived MATCHES "^([0-9a-f]+) ([-0-9]+)$")
    set(commit ${CMAKE_MATCH_1})
    set(date ${CMAKE_MATCH_2})
  endif()
endif()
set(text "#include \"cli/build_info.h\"

namespace cairn {

const char* BuildCommit() { return \"${commit}\"; }
const char* BuildDate() { return \"${date}\"; }

}  // namespace cairn
")
set(old "")
if(EXISTS ${OUT})
  file(READ ${OUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUT} "${text}")
endif()
