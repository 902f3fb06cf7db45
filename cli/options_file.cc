#include "cli/options_file.h"

#include <CLI/CLI.hpp>
#include <string>

#include "cli/options/read_options.h"

namespace cairn {

void AddOptionsFile(CLI::App* command, CairnOptions* options) {
  // CLI11 takes the values of a command line in the order in which its flags were added.
  command
      ->add_option_function<std::string>(
          "--options", [options](const std::string& path) { ReadOptionsFile(path, options); },
          "Options as JSON; flags win over the file. 'cairn options' prints all at their defaults")
      ->type_name("FILE.json");
}

}  // namespace cairn
