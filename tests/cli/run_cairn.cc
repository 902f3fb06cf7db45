#include "cli/run_cairn.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

int WaitForExit(pid_t pid) {
  int status = 0;
  if (waitpid(pid, &status, 0) != pid) {
    throw std::runtime_error("waitpid failed");
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Becomes `<binary> <arguments>`; never returns.
[[noreturn]] void Exec(const char* binary, const std::vector<std::string>& arguments) {
  std::vector<char*> argv = {const_cast<char*>(binary)};
  for (const std::string& argument : arguments) {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  execv(binary, argv.data());
  _exit(127);
}

void Redirect(const std::string& path, int flags, int fd) {
  const int file = open(path.c_str(), flags, 0600);
  if (file < 0 || dup2(file, fd) < 0) {
    _exit(127);
  }
  close(file);
}

std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Finished RunBinary(const char* binary, const std::vector<std::string>& arguments,
                   const std::string& input) {
  const TempDir dir;
  std::ofstream(dir.File("in"), std::ios::binary) << input;
  const pid_t pid = fork();
  if (pid == 0) {
    Redirect(dir.File("in"), O_RDONLY, STDIN_FILENO);
    Redirect(dir.File("out"), O_WRONLY | O_CREAT, STDOUT_FILENO);
    Redirect(dir.File("err"), O_WRONLY | O_CREAT, STDERR_FILENO);
    Exec(binary, arguments);
  }
  Finished finished;
  finished.exit_code = WaitForExit(pid);
  finished.out = ReadAll(dir.File("out"));
  finished.err = ReadAll(dir.File("err"));
  return finished;
}

}  // namespace

Finished RunCairn(const std::vector<std::string>& arguments, const std::string& input) {
  return RunBinary(CAIRN_BINARY, arguments, input);
}

Finished RunCairnLab(const std::vector<std::string>& arguments) {
  return RunBinary(CAIRN_LAB_BINARY, arguments, "");
}

BackgroundCairn::BackgroundCairn(const std::vector<std::string>& arguments) {
  int pipe_fds[2];
  if (pipe(pipe_fds) != 0) {
    throw std::runtime_error("pipe failed");
  }
  pid_ = fork();
  if (pid_ == 0) {
    dup2(pipe_fds[1], STDOUT_FILENO);
    close(pipe_fds[0]);
    close(pipe_fds[1]);
    Exec(CAIRN_BINARY, arguments);
  }
  close(pipe_fds[1]);
  out_fd_ = pipe_fds[0];
}

BackgroundCairn::~BackgroundCairn() {
  if (pid_ > 0) {
    Stop(SIGKILL);
  }
  close(out_fd_);
}

std::string BackgroundCairn::ReadLine() {
  std::string line;
  char c = 0;
  while (read(out_fd_, &c, 1) == 1 && c != '\n') {
    line += c;
  }
  return line;
}

void BackgroundCairn::Signal(int signal) const { kill(pid_, signal); }

int BackgroundCairn::Stop(int signal) {
  Signal(signal);
  const int exit_code = WaitForExit(pid_);
  pid_ = -1;
  return exit_code;
}

int RunInChild(const std::function<void()>& work) {
  const pid_t pid = fork();
  if (pid == 0) {
    try {
      work();
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  return WaitForExit(pid);
}

}  // namespace cairn::testing
