// A folder of the build with a program for Node.js and the packages of its lock file.
#ifndef CAIRN_TESTS_CLI_NPM_FOLDER_H_
#define CAIRN_TESTS_CLI_NPM_FOLDER_H_

#include <filesystem>
#include <string>
#include <utility>

namespace cairn::testing {

// Returns the output, standard error included, and the exit code of a shell command.
std::pair<std::string, int> RunShell(const std::string& command);

// The packages are installed once for a build. Needs Node.js, npm and, the first time, the network.
class NpmFolder {
 public:
  // Copies tests/cli/NAME and installs its packages.
  explicit NpmFolder(const std::string& name);

  // Why the packages cannot be installed; empty if they are.
  const std::string& why_not() const { return why_not_; }
  const std::filesystem::path& path() const { return path_; }

  // Runs a shell command in the folder.
  std::pair<std::string, int> Run(const std::string& command) const;

 private:
  std::filesystem::path path_;
  std::string why_not_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_CLI_NPM_FOLDER_H_
