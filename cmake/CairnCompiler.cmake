# Flags that hold for every target.
add_library(cairn_compiler_options INTERFACE)
target_compile_options(cairn_compiler_options INTERFACE
  -Wall -Wextra $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>
  -Wnon-virtual-dtor -Woverloaded-virtual -Wno-unused-parameter
  # GCC 12's flow-based warnings see overflows, overlaps and uses after free in inlined std::vector,
  # std::string and Eigen code that are not there, more of them at -O3.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-maybe-uninitialized -Wno-use-after-free>
  # A source that is compiled together with others looks like a header to GCC, so that a class with a
  # member of a type of the source's own looks like two classes.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wno-subobject-linkage>
  # With the compiler of Debian 12, which CI has; others may see what it does not.
  $<$<AND:$<BOOL:${PROJECT_IS_TOP_LEVEL}>,$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,12>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Werror>)

# The baseline of x86-64 has no fused multiply-add. Where the baseline has one, as on arm64, the
# compiler would use it wherever it finds a product and a sum, and what is stored would have other
# last bits.
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  target_compile_options(cairn_compiler_options INTERFACE -ffp-contract=off)
endif()

if(PROJECT_IS_TOP_LEVEL)
  if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE Release)
  endif()
  set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1 -DNDEBUG")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # The compiler looks for garbage less often: a tenth less time for a quarter more memory.
    add_compile_options(--param=ggc-min-expand=300 --param=ggc-min-heapsize=400000)
  endif()
endif()
if(CAIRN_ASSERTIONS)
  string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")
endif()

# Tests spend their time in the libraries. Their own code compiles in three quarters of the time so.
set(cairn_test_options $<$<CONFIG:Release>:-O1>)

if(CAIRN_SANITIZE)
  add_compile_options(-fsanitize=${CAIRN_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CAIRN_SANITIZE})
  if(CAIRN_SANITIZE STREQUAL thread)
    # It does not follow fences. Those of fusion/client/published.h order atomics, which cannot race.
    add_compile_options(-Wno-tsan)
  endif()
endif()
if(CAIRN_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()

# ccache does not keep what was compiled with a precompiled header unless it is told that macros of
# the date and the command line are of no importance to it.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND PROJECT_IS_TOP_LEVEL)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER
      env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
endif()
find_program(MOLD_PROGRAM mold)
if(MOLD_PROGRAM AND PROJECT_IS_TOP_LEVEL)
  add_link_options(-fuse-ld=mold)
endif()
# Programs load the libraries that they use, not all that their parts might.
if(PROJECT_IS_TOP_LEVEL)
  add_link_options(-Wl,--as-needed)
endif()
