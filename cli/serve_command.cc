// `cairn serve`: answers queries over HTTP until SIGINT or SIGTERM.
#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "cli/index_option.h"
#include "cli/shell.h"
#include "core/logging.h"
#include "http/server.h"

namespace cairn {
namespace {

struct ServeArguments {
  ServerOptions options;
  int64_t cache_mb = 1024;
  int64_t max_body_mb = 16;
  double max_image_megapixels = 12.0;
};

// Keeps SIGINT and SIGTERM from every thread that is started from now on, so that one can wait for
// them.
sigset_t BlockStopSignals() {
  sigset_t stop_signals;
  sigemptyset(&stop_signals);
  sigaddset(&stop_signals, SIGINT);
  sigaddset(&stop_signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stop_signals, nullptr);
  return stop_signals;
}

// glibc gives every thread a heap of its own, and each keeps what its largest request took: 72 MB
// after a photo of 450,000 pixels. With as many heaps as cores, the server's memory is the tile
// cache plus a constant that --threads does not multiply. Call before there are threads.
void ShareHeapsAmongThreads() {
  mallopt(M_ARENA_MAX, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

std::string Url(const std::string& host, int port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return is_ipv6 ? fmt::format("http://[{}]:{}", host, port)
                 : fmt::format("http://{}:{}", host, port);
}

ExitCode RunServe(const ServeArguments& arguments) {
  ServerOptions options = arguments.options;
  options.cache_bytes = static_cast<size_t>(arguments.cache_mb) << 20;
  options.max_body_bytes = static_cast<size_t>(arguments.max_body_mb) << 20;
  options.max_image_pixels = std::llround(1e6 * arguments.max_image_megapixels);
  ShareHeapsAmongThreads();
  const sigset_t stop_signals = BlockStopSignals();
  Server server(options);
  server.Start();
  fmt::print("{}\n", Url(options.host, server.port()));
  if (options.admin_port >= 0) {
    LogInfo("health and metrics on {}", Url(options.admin_host, server.admin_port()));
  }
  std::fflush(stdout);

  int signal_number = 0;
  sigwait(&stop_signals, &signal_number);
  LogInfo("stopping after the running requests");
  server.Stop();
  return signal_number == SIGINT ? ExitCode::kInterrupted : ExitCode::kOk;
}

}  // namespace

void AddServeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("serve", "Answer localization queries over HTTP");
  auto arguments = std::make_shared<ServeArguments>();
  ServerOptions& options = arguments->options;
  command->add_option("MAP", options.map_path, "Map file")->required();
  command->add_option("--host", options.host, "Address to listen on")->capture_default_str();
  command->add_option("--port", options.port, "Port to listen on; 0 picks a free one")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT")
      ->capture_default_str();
  command
      ->add_option("--admin-port", options.admin_port,
                   "Loopback port for health and metrics alone; 0 picks a free one, -1 has them on "
                   "the main port")
      ->check(CLI::Range(-1, 65535))
      ->type_name("PORT")
      ->capture_default_str();
  command->add_option("--cache-mb", arguments->cache_mb, "Memory for decoded tiles, MiB")
      ->check(CLI::Range(int64_t{1}, int64_t{1} << 24))
      ->type_name("MB")
      ->capture_default_str();
  command
      ->add_option("--threads", options.num_threads,
                   "Connections served at once; 0 is 64, or twice the cores if that is more")
      ->check(CLI::Range(0, 4096))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--query-threads", options.threads_per_query,
                   "Threads one query may use while cores are free; 0 is as many as cores")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option(
          "--max-body-mb", arguments->max_body_mb,
          "Largest request, MiB; 12 megapixels take up to 16 as JPEG or as GRAY8 in base64")
      ->check(CLI::Range(int64_t{1}, int64_t{1024}))
      ->type_name("MB")
      ->capture_default_str();
  command
      ->add_option("--max-image-mp", arguments->max_image_megapixels,
                   "Largest image that is decoded, megapixels")
      ->check(CLI::Range(0.01, 1000.0))
      ->type_name("MP")
      ->capture_default_str();
  AddIndexOption(command, &options.localizer.matching.index.kind);
  command->footer(
      "Prints the URL when it is ready. SIGTERM and SIGINT stop it after the running requests.\n"
      "Example:\n"
      "  cairn serve city.gpkg --port 8080");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunServe(*arguments); }; });
}

}  // namespace cairn
