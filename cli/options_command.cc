// `cairn options`: the options that --options takes, at their defaults.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/options/write_options.h"
#include "cli/shell.h"

namespace cairn {

void AddOptionsCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("options", "Print what --options can set, at its defaults, as JSON");
  auto as_markdown = std::make_shared<bool>(false);
  command->add_flag("--markdown", *as_markdown, "Print the page docs/options.md");
  command->footer(
      "Example:\n"
      "  cairn options > options.json");
  command->callback([shell, as_markdown] {
    shell->run = [as_markdown] {
      const CairnOptions defaults;
      fmt::print("{}", *as_markdown ? OptionsAsMarkdown(defaults) : OptionsAsJson(defaults));
      return ExitCode::kOk;
    };
  });
}

}  // namespace cairn
