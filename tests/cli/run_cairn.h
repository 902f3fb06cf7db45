// Runs the built binaries like a shell.
#ifndef CAIRN_TESTS_CLI_RUN_CAIRN_H_
#define CAIRN_TESTS_CLI_RUN_CAIRN_H_

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace cairn::testing {

struct Finished {
  int exit_code = -1;  // 128 + signal number if a signal ended it.
  std::string out;     // Standard output.
  std::string err;     // Standard error.
};

// Runs `cairn <arguments>` until it ends. `input` becomes its standard input.
Finished RunCairn(const std::vector<std::string>& arguments, const std::string& input = "");

// Runs `cairn-lab <arguments>` until it ends.
Finished RunCairnLab(const std::vector<std::string>& arguments);

// A `cairn` process in the background. The destructor kills it if it still runs.
class BackgroundCairn {
 public:
  explicit BackgroundCairn(const std::vector<std::string>& arguments);
  ~BackgroundCairn();
  BackgroundCairn(const BackgroundCairn&) = delete;
  BackgroundCairn& operator=(const BackgroundCairn&) = delete;

  // Waits for the first line of standard output and returns it without its newline; empty if there
  // is none.
  std::string ReadLine();

  void Signal(int signal) const;

  // Sends the signal, waits for the process to end, and returns the exit code as in
  // Finished::exit_code.
  int Stop(int signal);

 private:
  pid_t pid_ = -1;
  int out_fd_ = -1;
};

// Runs `work` in a forked process that ends when `work` returns. Returns its exit code. Use for
// code that must die in the middle.
int RunInChild(const std::function<void()>& work);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_CLI_RUN_CAIRN_H_
