#include "cli/help_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/make_folders.h"
#include "cli/manual/bash_completion.h"
#include "cli/manual/man_page.h"
#include "cli/usage_message.h"
#include "core/file_bytes.h"

namespace cairn {
namespace {

ExitCode WriteManual(const CLI::App& app, const ProgramBuild& build, const std::string& folder) {
  const std::filesystem::path man = std::filesystem::path(folder) / "man1";
  const std::filesystem::path completions = std::filesystem::path(folder) / "completions";
  MakeFolders(man.string());
  MakeFolders(completions.string());
  const CommandTable table = TableOf(app);
  for (const ManPage& page : MakeManPages(table, build.version, build.date)) {
    WriteTextFile((man / page.file_name).string(), page.text);
  }
  WriteTextFile((completions / table.name).string(), MakeBashCompletion(table));
  return ExitCode::kOk;
}

}  // namespace

void AddHelpCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("help", "Explain a verb");
  command->fallthrough(false);  // The names of verbs are arguments here.
  auto words = std::make_shared<std::vector<std::string>>();
  command->add_option("VERB", *words, "Verb to explain. Default: list all verbs");
  command->footer(fmt::format("Example:\n  {} help {}", app->get_name(),
                              app->get_subcommands({}).front()->get_name()));
  command->callback([app, shell, words] {
    shell->run = [app, words] {
      std::string path = app->get_name();
      for (const std::string& word : *words) {
        path += " " + word;
      }
      // Not app->help(), which explains the verb that was called: this one.
      fmt::print("{}", app->get_formatter()->make_help(&FindVerb(*app, *words), path,
                                                       CLI::AppFormatMode::Normal));
      return ExitCode::kOk;
    };
  });
}

void AddWriteManualCommand(CLI::App* app, Shell* shell, const ProgramBuild& build) {
  CLI::App* command = app->add_subcommand("write-manual", "Write man pages and completion");
  command->group("");  // Hidden.
  auto folder = std::make_shared<std::string>();
  command->add_option("DIR", *folder, "Folder to write to")->required();
  command->callback([app, shell, build, folder] {
    shell->run = [app, build, folder] { return WriteManual(*app, build, *folder); };
  });
}

}  // namespace cairn
