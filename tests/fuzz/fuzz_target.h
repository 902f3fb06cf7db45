// Common code of the fuzz targets.
//
// A target is a file `<name>_fuzz.cc` that defines LLVMFuzzerTestOneInput. The function passes the
// bytes to a decoder, catches only the errors that the decoder documents, and checks the properties
// of a result with CAIRN_CHECK. `scripts/fuzz` runs the targets with libFuzzer. The ordinary build
// replays the inputs in `corpus/<name>/` as a test. The release preset compiles all targets as one
// source, so their names in anonymous namespaces differ.
#ifndef CAIRN_TESTS_FUZZ_FUZZ_TARGET_H_
#define CAIRN_TESTS_FUZZ_FUZZ_TARGET_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/check.h"

// Returns 0. Every exception that leaves the function is a finding, and so is every abort.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace cairn::testing {

inline std::string_view AsText(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_FUZZ_FUZZ_TARGET_H_
