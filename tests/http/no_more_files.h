// A process without free file descriptors.
#ifndef CAIRN_TESTS_HTTP_NO_MORE_FILES_H_
#define CAIRN_TESTS_HTTP_NO_MORE_FILES_H_

#include <sys/resource.h>
#include <unistd.h>

namespace cairn::testing {

// UBSan opens a pipe to look at a virtual table.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitizerNeedsFiles = true;
#else
inline constexpr bool kSanitizerNeedsFiles = false;
#endif

// The process may open no more files than are open now, as long as this lives.
class NoMoreFiles {
 public:
  NoMoreFiles() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const int next = dup(0);
    close(next);
    const rlimit limit{.rlim_cur = static_cast<rlim_t>(next), .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  ~NoMoreFiles() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_HTTP_NO_MORE_FILES_H_
