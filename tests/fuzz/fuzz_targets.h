// The fuzz targets of builds without libFuzzer, in which all of them are in one program.
#ifndef CAIRN_TESTS_FUZZ_FUZZ_TARGETS_H_
#define CAIRN_TESTS_FUZZ_FUZZ_TARGETS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace cairn::testing {

struct FuzzTarget {
  std::string_view name;
  int (*run)(const uint8_t* data, size_t size);  // LLVMFuzzerTestOneInput of the target.
};

std::span<const FuzzTarget> FuzzTargets();

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_FUZZ_FUZZ_TARGETS_H_
