#include "cli/client_key.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <string_view>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"

namespace cairn {
namespace {

constexpr char kKeyVariable[] = "CAIRN_API_KEY";
constexpr uint64_t kMaxKeyFileBytes = 4096;

// A key is for its owner and maybe a group of services.
void WarnIfOthersMayRead(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode) && (info.st_mode & S_IRWXO) != 0) {
    LogWarning("{}: everybody on this machine may read the API key; 'chmod 600' mends that", path);
  }
}

}  // namespace

std::string ClientKeyArguments::Read() const {
  if (file.empty()) {
    const char* const value = std::getenv(kKeyVariable);
    return value == nullptr ? "" : value;
  }
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::string text = ReadTextFile(file, kMaxKeyFileBytes);
  const size_t begin = text.find_first_not_of(kBlanks);
  const std::string key = begin == std::string::npos
                              ? ""
                              : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
  if (key.empty() || key.find_first_of(kBlanks) != std::string::npos) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: expected one word, the API key, and nothing else", file));
  }
  WarnIfOthersMayRead(file);
  return key;
}

void RefuseKeyOnCommandLine(CLI::App* command, const std::string& instead) {
  command
      ->add_option_function<std::string>(
          "--api-key",
          [instead](const std::string&) {
            throw Error(ErrorCode::kInvalidArgument,
                        "--api-key: everybody on this machine can read a key on the command line, "
                        "and the shell remembers it; " +
                            instead);
          },
          "Refused")
      ->group("");  // Hidden from the help.
}

void AddClientKeyOptions(CLI::App* command, CLI::Option* server, ClientKeyArguments* key) {
  command
      ->add_option("--api-key-file", key->file,
                   "File with the API key for the server. Default: the key in the environment "
                   "variable CAIRN_API_KEY, if it is set")
      ->type_name("FILE")
      ->needs(server);
  command
      ->add_flag("--insecure-key", key->allow_plain,
                 "Send the API key also over plain http to another machine, where everybody on the "
                 "way can read it")
      ->needs(server);
  RefuseKeyOnCommandLine(
      command, fmt::format("write it to a file for --api-key-file, or set {}", kKeyVariable));
}

}  // namespace cairn
