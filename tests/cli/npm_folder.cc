#include "cli/npm_folder.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>

namespace cairn::testing {

namespace fs = std::filesystem;

std::pair<std::string, int> RunShell(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer;
  while (const size_t size = fread(buffer.data(), 1, buffer.size(), pipe)) {
    text.append(buffer.data(), size);
  }
  const int status = pclose(pipe);
  return {text, WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

NpmFolder::NpmFolder(const std::string& name)
    : path_(fs::path(CAIRN_BINARY_DIR) / (name + "_test")) {
  if (RunShell("node --version && npm --version").second != 0) {
    why_not_ = "node and npm are not installed";
    return;
  }
  fs::create_directories(path_);
  for (const fs::directory_entry& file :
       fs::directory_iterator(fs::path(CAIRN_SOURCE_DIR) / "tests/cli" / name)) {
    fs::copy_file(file.path(), path_ / file.path().filename(),
                  fs::copy_options::overwrite_existing);
  }
  // A copy of the lock file is the mark that all of its packages are there. Tests run at the same
  // time.
  const auto [text, code] =
      Run("flock install.lock sh -c 'cmp --quiet package-lock.json node_modules/.installed || "
          "{ npm ci --prefer-offline --fetch-retries=0 --ignore-scripts --no-audit --no-fund && "
          "cp package-lock.json node_modules/.installed; }'");
  why_not_ =
      code == 0 ? "" : "npm cannot install the packages of " + name + ": " + text.substr(0, 500);
}

std::pair<std::string, int> NpmFolder::Run(const std::string& command) const {
  return RunShell("cd '" + path_.string() + "' && " + command);
}

}  // namespace cairn::testing
