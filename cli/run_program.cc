#include "cli/run_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>

#include "cli/choice_option.h"
#include "cli/exit_codes.h"
#include "cli/help_command.h"
#include "cli/shell.h"
#include "cli/usage_message.h"
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
  static constexpr EnumName<ProgressMode> kProgressModes[] = {{"auto", ProgressMode::kAuto},
                                                              {"bar", ProgressMode::kBar},
                                                              {"plain", ProgressMode::kPlain},
                                                              {"json", ProgressMode::kJson}};
  static constexpr EnumName<LogLevel> kLogLevels[] = {{"debug", LogLevel::kDebug},
                                                      {"info", LogLevel::kInfo},
                                                      {"warning", LogLevel::kWarning},
                                                      {"error", LogLevel::kError},
                                                      {"off", LogLevel::kOff}};
  AddChoiceOption(app, "--progress", NamedChoice(&shell->progress_mode, kProgressModes),
                  "Style of the progress on stderr");
  AddChoiceOption(app, "--log-level", NamedChoice(log_level, kLogLevels),
                  "Minimum severity of messages logged to stderr");
}

ExitCode Report(const Program& program, ExitCode exit_code, const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", program.name, PrintableLines(message).c_str());
  return exit_code;
}

// Several lines: the version, and what the program was built from.
std::string VersionText(const Program& program) {
  const ProgramBuild& build = program.build;
  const std::string date = build.date.empty() ? "" : fmt::format(" of {}", build.date);
  return fmt::format("{} {}\ncommit     {}{}\ncompiler   {}\nlibraries  {}", program.name,
                     build.version, build.commit.empty() ? "unknown" : build.commit, date,
                     build.compiler, build.libraries);
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
  app.set_version_flag("--version", VersionText(program));
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Exit codes: 0 ok, 1 internal, 2 usage, 3 not localized, 4 bad input, 5 map damaged, 6 I/O,\n"
      "7 server unreachable, 130 interrupted.");
  Shell shell;
  shell.commit = program.build.commit;
  shell.program_path = argv[0];
  LogLevel log_level = LogLevel::kInfo;
  AddGlobalOptions(&app, &shell, &log_level);
  program.add_verbs(&app, &shell);
  AddHelpCommand(&app, &shell);
  AddWriteManualCommand(&app, &shell, program.build);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    app.exit(help_or_version);
    FlushOutput();
    return ExitCode::kOk;
  } catch (const CLI::ParseError& error) {
    return Report(program, ExitCode::kUsage, UsageMessage(app, error, argc, argv));
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
