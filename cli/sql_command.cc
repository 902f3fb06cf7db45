// `cairn sql`: read-only SQL over a map.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "cli/json_output.h"
#include "cli/row_printer.h"
#include "cli/shell.h"
#include "core/error.h"
#include "storage/map/sql_shell.h"

namespace cairn {
namespace {

struct SqlArguments {
  std::string map_path;
  std::string query;  // If empty, stdin is read.
  RowFormat format = RowFormat::kTable;
  bool json = false;  // As the format of that name.
  SqlOptions options;
};

std::string ReadStandardInput() {
  constexpr size_t kMaxBytes = size_t{16} << 20;
  std::string text(kMaxBytes + 1, '\0');
  std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(std::cin.gcount()));
  if (text.size() > kMaxBytes) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("standard input: more than {} bytes of SQL", kMaxBytes));
  }
  return text;
}

// Ends the process if SQLite does not stop by itself when the time is up: it notices nothing while
// it computes one huge value, and while nobody reads the output.
class LastResort {
 public:
  explicit LastResort(double timeout_s)
      : thread_([timeout_s](const std::stop_token& stop) {
          constexpr double kGraceS = 1.0;
          std::mutex mutex;
          std::condition_variable_any wake;
          std::unique_lock lock(mutex);
          wake.wait_for(lock, stop, std::chrono::duration<double>(timeout_s + kGraceS),
                        [] { return false; });
          if (!stop.stop_requested()) {
            fmt::print(stderr,
                       "cairn: SQL: stopped because the time is up; set a longer --timeout or "
                       "select less\n");
            std::_Exit(static_cast<int>(ExitCode::kBadInput));
          }
        }) {}

 private:
  std::jthread thread_;  // Stopped and joined on destruction.
};

ExitCode RunSqlCommand(const SqlArguments& arguments) {
  std::string query = arguments.query;
  if (query.empty()) {
    query = ReadStandardInput();
  }
  const LastResort last_resort(arguments.options.timeout_s);
  const std::unique_ptr<RowPrinter> printer = MakeRowPrinter(
      arguments.json ? RowFormat::kJson : arguments.format, isatty(STDOUT_FILENO) == 1);
  SqlSink sink;
  sink.on_columns = [&](const std::vector<std::string>& names) { printer->BeginResult(names); };
  sink.on_row = [&](const std::vector<SqlCell>& row) { printer->AddRow(row); };
  RunSql(arguments.map_path, query, arguments.options, sink);
  printer->Finish();
  return ExitCode::kOk;
}

}  // namespace

void AddSqlCommand(CLI::App* app, Shell* shell) {
  static constexpr EnumName<RowFormat> kFormats[] = {
      {"table", RowFormat::kTable}, {"csv", RowFormat::kCsv}, {"json", RowFormat::kJson}};
  CLI::App* command = app->add_subcommand("sql", "Query a map with SQL (read-only)");
  auto arguments = std::make_shared<SqlArguments>();
  command->add_option("MAP", arguments->map_path, "Map file")->required();
  command->add_option("QUERY", arguments->query, "SQL statements. Default: read from stdin");
  CLI::Option* format = AddChoiceOption(
      command, "--format", NamedChoice(&arguments->format, kFormats), "Output format of the rows");
  AddJsonFlag(command, &arguments->json)->excludes(format);
  command
      ->add_option("--timeout", arguments->options.timeout_s,
                   "Time limit of the statements and of their output, seconds")
      ->check(NumberWithin(1e-3, 1e6))
      ->type_name("S")
      ->capture_default_str();
  command->footer(
      "Example:\n"
      "  cairn sql city.gpkg \"SELECT * FROM v_sessions\"\n"
      "More queries: sql/README.md");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunSqlCommand(*arguments); }; });
}

}  // namespace cairn
