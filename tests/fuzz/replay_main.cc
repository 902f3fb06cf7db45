// Runs a fuzz target once on each file of a folder: cairn_fuzz_replay TARGET FOLDER. This is how
// the targets are tested in builds without libFuzzer.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz/fuzz_targets.h"

namespace {

namespace fs = std::filesystem;
using cairn::testing::FuzzTarget;
using cairn::testing::FuzzTargets;

std::vector<fs::path> FilesOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

void Replay(const FuzzTarget& target, const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file),
                                std::istreambuf_iterator<char>()};
  target.run(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: {} TARGET FOLDER\n", argv[0]);
    return 2;
  }
  const auto target = std::find_if(FuzzTargets().begin(), FuzzTargets().end(),
                                   [&](const FuzzTarget& t) { return t.name == argv[1]; });
  if (target == FuzzTargets().end()) {
    fmt::print(stderr, "there is no target {}\n", argv[1]);
    return 2;
  }
  std::string current = argv[2];
  try {
    const std::vector<fs::path> files = FilesOf(argv[2]);
    for (const fs::path& path : files) {
      current = path.string();
      Replay(*target, path);
    }
    fmt::print("{} inputs replayed\n", files.size());
    return files.empty() ? 1 : 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", current, e.what());
    return 1;
  }
}
