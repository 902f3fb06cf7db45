// `cairn serve`: answers queries over HTTP until SIGINT or SIGTERM. SIGHUP reopens the map and
// reads the API keys again.
#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "cli/client_key.h"
#include "cli/index_option.h"
#include "cli/options_file.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/log_sink.h"
#include "core/logging.h"
#include "core/memory_reserve.h"
#include "core/parallel_for.h"
#include "http/server.h"

namespace cairn {
namespace {

constexpr size_t kMemoryReserveBytes = size_t{16} << 20;

constexpr std::array kSignals = {SIGHUP, SIGINT, SIGTERM};

// The write end of a SignalQueue's pipe, for the signal handler.
std::atomic<int> signal_pipe{-1};

extern "C" void QueueSignal(int signal_number) {
  const int error = errno;
  const auto byte = static_cast<char>(signal_number);
  [[maybe_unused]] const ssize_t ignored = write(signal_pipe, &byte, 1);
  errno = error;
}

// Queues the signals that the server handles, in order of arrival, from its construction on. A pipe
// replaces sigwait, because libraries run their own threads: a signal that arrives there while no
// thread waits would end the process.
class SignalQueue {
 public:
  SignalQueue() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0 || fcntl(ends[1], F_SETFL, O_NONBLOCK) != 0) {
      throw Error(ErrorCode::kIo, "cannot create a pipe");
    }
    read_end_ = ends[0];
    signal_pipe = ends[1];
    for (const int signal_number : kSignals) {
      std::signal(signal_number, QueueSignal);
    }
  }
  // Threads started between the two calls get no signals.
  static void Block(int how) {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal_number : kSignals) {
      sigaddset(&signals, signal_number);
    }
    pthread_sigmask(how, &signals, nullptr);
  }
  // Returns the next signal, or nothing if none arrives within `patience`.
  std::optional<int> WaitFor(std::chrono::milliseconds patience) const {
    pollfd poll_fd{.fd = read_end_, .events = POLLIN, .revents = 0};
    char byte = 0;
    if (poll(&poll_fd, 1, static_cast<int>(patience.count())) <= 0 ||
        read(read_end_, &byte, 1) != 1) {
      return std::nullopt;
    }
    return byte;
  }

 private:
  int read_end_ = -1;
};

// The log of `cairn serve 2>&1 | tee log` may lose its reader, which would end the process, or the
// reader may stop reading, which would halt every thread that logs.
void OutliveReadersOfTheLog() {
  std::signal(SIGPIPE, SIG_IGN);
  SetLogWaits(false);
}

// Connections and maps need more open files than the default limit of 1,024. A process may raise
// its own limit.
void AllowOpenFiles() {
  constexpr rlim_t kEnough = 8192;
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= kEnough) {
    return;
  }
  files.rlim_cur = std::min(files.rlim_max, kEnough);
  setrlimit(RLIMIT_NOFILE, &files);
}

// glibc gives every thread its own heap, and each heap keeps the memory of its largest request: 72
// MB after a photo of 450,000 pixels. With as many heaps as cores, the server's memory is the tile
// cache plus a constant, independent of --threads. Call before any thread starts.
void ShareHeapsAmongThreads() { mallopt(M_ARENA_MAX, NumCores()); }

// Serves until SIGINT or SIGTERM arrives, which it returns, or until `end`, when it returns
// nothing. SIGHUP reads the keys again and reopens the map and the access log. After every second
// with requests, returns freed memory to the system, because glibc would keep it.
std::optional<int> ServeUntil(std::chrono::steady_clock::time_point end, const SignalQueue& signals,
                              Server* server) {
  using std::chrono::milliseconds;
  uint64_t num_requests = 0;
  while (true) {
    const auto left = std::chrono::ceil<milliseconds>(end - std::chrono::steady_clock::now());
    if (left <= milliseconds(0)) {
      return std::nullopt;
    }
    const std::optional<int> signal_number = signals.WaitFor(std::min(left, milliseconds(1000)));
    if (signal_number == SIGHUP) {
      server->ReloadKeys();  // First: a removed key must not wait for a slow map.
      server->ReloadMap();
      server->ReopenAccessLog();
    } else if (signal_number) {
      return signal_number;
    }
    RefillMemoryReserve();
    if (num_requests != server->num_requests()) {
      num_requests = server->num_requests();
      malloc_trim(0);
    }
  }
}

// Serves until SIGINT or SIGTERM, drains after SIGTERM, and stops. A second signal ends the drain;
// a signal after that ends the process. Returns the first signal.
int ServeAndStop(const ServerOptions& options, const SignalQueue& signals, Server* server) {
  constexpr auto kForever = std::chrono::steady_clock::time_point::max();
  const int signal_number = *ServeUntil(kForever, signals, server);
  if (signal_number == SIGTERM && options.drain_s > 0) {
    LogInfo("draining for {} s: /readyz answers 503, queries are still answered", options.drain_s);
    server->Drain();
    ServeUntil(std::chrono::steady_clock::now() + std::chrono::seconds(options.drain_s), signals,
               server);
  }
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  LogInfo("stopping when the running requests have finished");
  server->Stop();
  return signal_number;
}

std::string Url(const std::string& host, int port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return is_ipv6 ? fmt::format("http://[{}]:{}", host, port)
                 : fmt::format("http://{}:{}", host, port);
}

ExitCode RunServe(const CairnOptions& arguments) {
  ServerOptions options = arguments.server;
  options.localizer = arguments.localizer;
  options.sift = arguments.sift;
  ShareHeapsAmongThreads();
  SetUpMemoryReserve(kMemoryReserveBytes);
  AllowOpenFiles();
  OutliveReadersOfTheLog();
  const SignalQueue signals;
  SignalQueue::Block(SIG_BLOCK);
  Server server(options);
  server.Start();
  SignalQueue::Block(SIG_UNBLOCK);
  fmt::print("{}\n", Url(options.host, server.port()));
  if (options.admin_port >= 0) {
    LogInfo("health and metrics on {}", Url(kAdminHost, server.admin_port()));
  }
  if (std::fflush(stdout) != 0) {
    throw Error(ErrorCode::kIo, "cannot write to standard output");
  }

  const int signal_number = ServeAndStop(options, signals, &server);
  return signal_number == SIGINT ? ExitCode::kInterrupted : ExitCode::kOk;
}

// A flag that sets `value` in units of `unit`.
template <typename Value, typename Unit>
CLI::Option* AddScaledOption(CLI::App* command, const std::string& flag, Value* value, Unit unit,
                             const std::string& description) {
  return command
      ->add_option_function<Unit>(
          flag,
          [value, unit](const Unit& number) {
            *value = static_cast<Value>(std::llround(static_cast<double>(number * unit)));
          },
          description)
      ->default_str(fmt::format("{}", static_cast<Unit>(*value) / unit));
}

void AddAddressOptions(CLI::App* command, ServerOptions* options) {
  command->add_option("--host", options->host, "Address to listen on")->capture_default_str();
  command->add_option("--port", options->port, "Port to listen on; 0 picks a free port")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT")
      ->capture_default_str();
  command
      ->add_option("--admin-port", options->admin_port,
                   "Separate loopback port for health and metrics; 0 picks a free port, -1 uses "
                   "the main port")
      ->check(CLI::Range(-1, 65535))
      ->type_name("PORT")
      ->capture_default_str();
}

void AddFrontOption(CLI::App* command, ServerOptions* options) {
  command
      ->add_option("--trusted-front", options->trusted_fronts,
                   "Fronts whose X-Forwarded-For names the client, which divides the server fairly "
                   "among the clients behind them: addresses or networks, separated by commas")
      ->type_name("ADDRESS,...");
}

// A variable of the shell that is not set must not open the server.
CLI::Validator NotEmpty() {
  return CLI::Validator(
      [](const std::string& text) {
        return text.empty() ? std::string("the name of the file is empty") : std::string();
      },
      "");
}

void AddKeysOption(CLI::App* command, ServerOptions* options) {
  command
      ->add_option_function<std::string>(
          "--api-keys", [options](const std::string& path) { options->api_keys_path = path; },
          "File of the API keys that may use the server ('cairn keys' writes it). Without "
          "it, everybody may do everything")
      ->check(NotEmpty())
      ->type_name("FILE");
  RefuseKeyOnCommandLine(command, "name a file with --api-keys");
}

void AddAccessLogOption(CLI::App* command, ServerOptions* options) {
  command
      ->add_option("--access-log", options->access_log_path,
                   "File to which each request to the port adds a line of JSON: client, label of "
                   "the key, path, status, bytes, time, reason. SIGHUP opens the file again")
      ->type_name("FILE");
}

void AddDrainOption(CLI::App* command, ServerOptions* options) {
  command
      ->add_option("--drain-seconds", options->drain_s,
                   "After SIGTERM, seconds in which /readyz answers 503 and queries are still "
                   "answered, so that a front sends its queries elsewhere")
      ->check(CLI::Range(0, kMaxDrainSeconds))
      ->type_name("S")
      ->capture_default_str();
}

void AddExifOption(CLI::App* command, ServerOptions* options) {
  command->add_flag(
      "!--no-exif-prior", options->exif_prior,
      "Do not take the position in a photo's EXIF as the prior of a request without one");
}

void AddLimitOptions(CLI::App* command, ServerOptions* options) {
  constexpr int64_t kMiB = int64_t{1} << 20;
  constexpr double kMegapixel = 1e6;
  AddScaledOption(command, "--cache-mb", &options->cache_bytes, kMiB,
                  "Memory for decoded tiles, MiB")
      ->check(CLI::Range(int64_t{1}, int64_t{1} << 24))
      ->type_name("MB");
  command
      ->add_option(
          "--threads", options->num_threads,
          "Requests answered at once; 0: 64 or twice the number of cores, whichever is more")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--query-threads", options->threads_per_query,
                   "Threads that one query may use while cores are free; 0: the number of cores")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
  AddScaledOption(command, "--max-body-mb", &options->max_body_bytes, kMiB,
                  "Largest request, MiB. A JPEG of 48 megapixels takes 10 to 24, an image of 12 "
                  "megapixels as GRAY8 in base64 takes 16")
      ->check(CLI::Range(int64_t{1}, int64_t{1024}))
      ->type_name("MB");
  AddScaledOption(command, "--max-image-mp", &options->max_image_pixels, kMegapixel,
                  "Largest image as it is decoded, megapixels. A JPEG may have 16 times as many "
                  "and is then decoded at a smaller scale")
      ->check(CLI::Range(0.01, 1000.0))
      ->type_name("MP");
}

}  // namespace

void AddServeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("serve", "Answer localization queries over HTTP");
  auto options = std::make_shared<CairnOptions>();
  command->add_option("MAP", options->server.map_path, "Map: a file or a postgresql:// URL")
      ->required();
  AddOptionsFile(command, options.get());
  AddAddressOptions(command, &options->server);
  AddLimitOptions(command, &options->server);
  AddDrainOption(command, &options->server);
  AddExifOption(command, &options->server);
  AddFrontOption(command, &options->server);
  AddKeysOption(command, &options->server);
  AddAccessLogOption(command, &options->server);
  AddIndexOption(command, &options->localizer.matching.index.kind);
  command->footer(
      "Prints the URL when the server is ready. SIGTERM and SIGINT stop the server after the\n"
      "running requests; with --drain-seconds, SIGTERM drains it first. A further signal ends the\n"
      "drain, and one after that the process. SIGHUP reopens the map and\n"
      "reads the API keys again.\n"
      "Example:\n"
      "  cairn serve city.gpkg --port 8080");
  command->callback([shell, options] { shell->run = [options] { return RunServe(*options); }; });
}

}  // namespace cairn
