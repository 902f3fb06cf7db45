#include "cli/run_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <new>
#include <string>
#include <system_error>

#include "cli/exit_codes.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/logging.h"
#include "core/printable.h"

namespace cairn {
namespace {

// A map file survives an exit at any moment, as it survives kill -9. `serve` handles SIGINT itself.
extern "C" void ExitOnInterrupt(int /*signal*/) {
  static constexpr char kMessage[] = "\ncairn: interrupted\n";
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1);
  _exit(static_cast<int>(ExitCode::kInterrupted));
}

void AddGlobalOptions(CLI::App* app, Shell* shell, LogLevel* log_level) {
  static const std::map<std::string, ProgressMode> kProgressModes = {
      {"auto", ProgressMode::kAuto},
      {"bar", ProgressMode::kBar},
      {"plain", ProgressMode::kPlain},
      {"json", ProgressMode::kJson}};
  static const std::map<std::string, LogLevel> kLogLevels = {{"debug", LogLevel::kDebug},
                                                             {"info", LogLevel::kInfo},
                                                             {"warning", LogLevel::kWarning},
                                                             {"error", LogLevel::kError},
                                                             {"off", LogLevel::kOff}};
  app->add_option("--progress", shell->progress_mode, "Style of the progress on stderr")
      ->transform(CLI::CheckedTransformer(kProgressModes).description(""))
      ->type_name("auto|bar|plain|json");
  app->add_option("--log-level", *log_level, "Minimum severity of messages logged to stderr")
      ->transform(CLI::CheckedTransformer(kLogLevels).description(""))
      ->type_name("debug|info|warning|error|off");
}

ExitCode Report(const Program& program, ExitCode exit_code, const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", program.name, PrintableLines(message).c_str());
  return exit_code;
}

// For command lines without a verb: the first word that is neither a global option nor a verb;
// empty if there is none.
std::string FirstUnknown(const CLI::App& app, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("-")) {
      return fmt::format("there is no verb '{}'", Excerpt(word));
    }
    const std::string name = word.substr(0, word.find('='));
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option == nullptr) {
      return fmt::format("there is no option '{}'", Excerpt(name));
    }
    i += option->get_expected_min() > 0 && name == word ? 1 : 0;
  }
  return "";
}

// Describes the fault of the command line and refers to the help.
std::string UsageMessage(const Program& program, const CLI::App& app, const CLI::ParseError& error,
                         int argc, char** argv) {
  constexpr size_t kMaxBytes = 500;
  const auto verbs = app.get_subcommands();
  if (!verbs.empty()) {
    return fmt::format("{}\nRun '{} {} --help' for help.", Excerpt(error.what(), kMaxBytes),
                       program.name, verbs.front()->get_name());
  }
  const std::string unknown = FirstUnknown(app, argc, argv);
  return fmt::format("{}\nRun '{} --help' for help.",
                     unknown.empty() ? Excerpt(error.what(), kMaxBytes) : unknown, program.name);
}

// Throws Error(kIo) unless all output has been written.
void FlushOutput() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw Error(ErrorCode::kIo, "cannot write to standard output");
  }
}

ExitCode ParseAndRun(const Program& program, int argc, char** argv) {
  CLI::App app(program.description, program.name);
  app.set_version_flag("--version", std::string(program.name) + " " CAIRN_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Exit codes: 0 ok, 1 internal, 2 usage, 3 not localized, 4 bad input, 5 map damaged, 6 I/O,\n"
      "7 server unreachable, 130 interrupted.");
  Shell shell;
  LogLevel log_level = LogLevel::kInfo;
  AddGlobalOptions(&app, &shell, &log_level);
  program.add_verbs(&app, &shell);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    app.exit(help_or_version);
    FlushOutput();
    return ExitCode::kOk;
  } catch (const CLI::ParseError& error) {
    return Report(program, ExitCode::kUsage, UsageMessage(program, app, error, argc, argv));
  }
  SetLogLevel(log_level);
  const ExitCode exit_code = shell.run();
  FlushOutput();
  return exit_code;
}

ExitCode RunShell(const Program& program, int argc, char** argv) {
  try {
    return ParseAndRun(program, argc, argv);
  } catch (const Error& error) {
    return Report(program, ExitCodeFor(error.code()), error.what());
  } catch (const std::system_error& error) {  // {fmt} throws it if output cannot be written.
    return Report(program, ExitCode::kIo,
                  std::string("the operating system refused: ") + error.what());
  } catch (const std::bad_alloc&) {
    return Report(program, ExitCode::kInternal, "out of memory");
  } catch (const std::exception& error) {
    return Report(program, ExitCode::kInternal, std::string("internal error: ") + error.what());
  }
}

}  // namespace

int RunProgram(const Program& program, int argc, char** argv) {
  std::signal(SIGINT, ExitOnInterrupt);
  return static_cast<int>(RunShell(program, argc, argv));
}

}  // namespace cairn
