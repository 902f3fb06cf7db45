// `cairn-lab codebook`: trains the codebook that comes with Cairn.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "core/file_bytes.h"
#include "core/printable.h"
#include "lab/cli/lab_verbs.h"
#include "lab/descriptors/street_codebook.h"
#include "storage/codebook/codebook_digest.h"

namespace cairn {
namespace {

struct CodebookArguments {
  std::string out_path;
  StreetCodebookOptions options;
};

ExitCode RunCodebook(const CodebookArguments& arguments, ProgressMode progress_mode) {
  Codebook codebook;
  {
    Progress progress(progress_mode);
    codebook = TrainStreetCodebook(arguments.options, [&](int done, int total) {
      progress.Update("rendering streets", done, total);
    });
  }
  const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
  WriteFileBytes(arguments.out_path, bytes);
  fmt::print("{}: {}, {} bytes\n", Printable(arguments.out_path), DigestOf(codebook), bytes.size());
  return ExitCode::kOk;
}

}  // namespace

void AddCodebookCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("codebook", "Train a codebook on rendered streets, for small maps");
  auto arguments = std::make_shared<CodebookArguments>();
  command->add_option("--out", arguments->out_path, "File to write")->required()->type_name("FILE");
  command->add_option("--streets", arguments->options.num_streets, "Number of streets")
      ->capture_default_str();
  command->add_option("--threads", arguments->options.num_threads, "Threads that render")
      ->capture_default_str();
  AddSeedOption(command, &arguments->options.seed, "Seed of the first street and of the training");
  command->footer(
      "The defaults make the codebook that comes with Cairn. Equal options give equal bytes.\n"
      "Example:\n"
      "  cairn-lab codebook --out ingest/codebook/shipped.codebook");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunCodebook(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
