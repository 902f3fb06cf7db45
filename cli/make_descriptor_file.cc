#include "cli/make_descriptor_file.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

#include "core/error.h"

namespace cairn {

std::shared_ptr<DescriptorFile> MakeDescriptorFile() {
  const char* named = std::getenv("TMPDIR");
  const std::string_view folder = named == nullptr ? "" : named;
  try {
    return DescriptorFile::Create(folder.empty() ? "/tmp" : std::string(folder));
  } catch (const Error& error) {
    throw Error(
        error.code(),
        fmt::format("{}. Name another folder in the environment variable TMPDIR", error.what()));
  }
}

}  // namespace cairn
