#include "support/postgres_cluster.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "core/error.h"
#include "storage/database/postgres/server.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;

constexpr uid_t kNobody = 65534;

// Returns the folder of initdb and postgres, in the newest version that there is.
std::string ProgramFolder() {
  std::string newest;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/usr/lib/postgresql", ignored)) {
    const fs::path folder = entry.path() / "bin";
    if (fs::exists(folder / "initdb") && folder.string() > newest) {
      newest = folder;
    }
  }
  return newest;
}

bool HasPostgis() {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/usr/share/postgresql", ignored)) {
    if (fs::exists(entry.path() / "extension/postgis.control")) {
      return true;
    }
  }
  return false;
}

// Becomes the program, as nobody if this is root, and ends when the test does.
[[noreturn]] void Become(const std::vector<std::string>& arguments, const std::string& log) {
  if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) {
    _exit(126);
  }
  prctl(PR_SET_PDEATHSIG, SIGQUIT);
  const int out = open(log.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  execv(argv[0], argv.data());
  _exit(127);
}

pid_t Spawn(const std::vector<std::string>& arguments, const std::string& log) {
  const pid_t pid = fork();
  if (pid == 0) {
    Become(arguments, log);
  }
  return pid;
}

// Whether the process still runs. A zombie does not: it has let go of its memory.
bool IsRunning(pid_t process) {
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(stat, text);
  const size_t name_end = text.rfind(')');
  return name_end != std::string::npos && name_end + 2 < text.size() && text[name_end + 2] != 'Z';
}

// Returns a port of 127.0.0.1 that was free just now.
int FreePort() {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  const bool is_bound =
      bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0 &&
      getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  close(listener);
  if (!is_bound) {
    throw std::runtime_error("no free port on 127.0.0.1");
  }
  return ntohs(address.sin_port);
}

}  // namespace

std::string PostgresCluster::WhyNot() {
  if (ProgramFolder().empty()) {
    return "PostgreSQL is not installed (scripts/install-dependencies --tests)";
  }
  return HasPostgis() ? "" : "PostGIS is not installed (scripts/install-dependencies --tests)";
}

PostgresCluster& PostgresCluster::Shared() {
  struct WithPostgis {
    // A new database copies template1 in a tenth of the time that it takes to add PostGIS.
    WithPostgis() { cluster.Execute("template1", "CREATE EXTENSION postgis"); }
    PostgresCluster cluster;
  };
  static WithPostgis shared;
  return shared.cluster;
}

PostgresCluster::PostgresCluster(const std::string& host_rules)
    : port_(host_rules.empty() ? 0 : FreePort()) {
  std::string pattern = (fs::temp_directory_path() / "cairn_pg_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr ||
      (geteuid() == 0 && chown(pattern.c_str(), kNobody, kNobody) != 0)) {
    throw std::runtime_error("cannot make a folder for PostgreSQL");
  }
  folder_ = pattern;
  const pid_t init = Spawn({ProgramFolder() + "/initdb", "-D", folder_ + "/data", "-A", "trust",
                            "-U", "cairn", "-E", "UTF8", "--locale=C", "--no-sync"},
                           folder_ + "/log");
  int status = 0;
  if (waitpid(init, &status, 0) != init || status != 0) {
    throw std::runtime_error("initdb failed");
  }
  if (!host_rules.empty()) {
    std::ofstream(folder_ + "/data/pg_hba.conf") << "local all all trust\n" << host_rules << "\n";
  }
  Start();
}

PostgresCluster::~PostgresCluster() {
  Kill();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void PostgresCluster::Start() {
  std::vector<std::string> arguments = {
      ProgramFolder() + "/postgres",
      "-D",
      folder_ + "/data",
      "-k",
      folder_,
      "-c",
      "fsync=off",
      "-c",
      port_ == 0 ? "listen_addresses=" : "listen_addresses=127.0.0.1"};
  if (port_ != 0) {
    arguments.insert(arguments.end(), {"-p", std::to_string(port_)});
  }
  server_ = Spawn(arguments, folder_ + "/log");
  while (true) {
    try {
      postgres::Server(Url("postgres")).Connect(postgres::Use::kRead, {});
      return;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnavailable || waitpid(server_, nullptr, WNOHANG) != 0) {
        throw;
      }
      std::this_thread::yield();
    }
  }
}

std::string PostgresCluster::Url(const std::string& database, const std::string& user) const {
  return "postgresql:///" + database + "?host=" + folder_ + "&user=" + user +
         (port_ == 0 ? "" : "&port=" + std::to_string(port_));
}

std::string PostgresCluster::HostUrl(const std::string& database, const std::string& user) const {
  return "postgresql://" + user + "@127.0.0.1:" + std::to_string(port_) + "/" + database;
}

void PostgresCluster::Execute(const std::string& database, const std::string& sql) {
  postgres::Server(Url(database)).Connect(postgres::Use::kWrite, {})->Execute(sql);
}

std::string PostgresCluster::CreateDatabase(const std::string& name) {
  Execute("postgres", "CREATE DATABASE \"" + name + "\"");
  return Url(name);
}

std::vector<pid_t> PostgresCluster::Processes() const {
  std::vector<pid_t> processes = {server_};
  std::ifstream children("/proc/" + std::to_string(server_) + "/task/" + std::to_string(server_) +
                         "/children");
  for (pid_t child = 0; children >> child;) {
    processes.push_back(child);
  }
  return processes;
}

void PostgresCluster::Kill() {
  if (server_ < 0) {
    return;
  }
  kill(server_, SIGSTOP);  // A server that still runs starts further processes meanwhile.
  waitpid(server_, nullptr, WUNTRACED);
  const std::vector<pid_t> processes = Processes();
  for (const pid_t process : processes) {
    kill(process, SIGKILL);
  }
  waitpid(server_, nullptr, 0);
  server_ = -1;
  // The next server refuses to start as long as one of these holds the shared memory.
  for (const pid_t process : processes) {
    while (IsRunning(process)) {
      std::this_thread::yield();
    }
  }
  fs::remove(folder_ + "/data/postmaster.pid");
}

void PostgresCluster::Freeze() {
  for (const pid_t process : Processes()) {
    kill(process, SIGSTOP);
  }
}

void PostgresCluster::Thaw() {
  for (const pid_t process : Processes()) {
    kill(process, SIGCONT);
  }
}

}  // namespace cairn::testing
