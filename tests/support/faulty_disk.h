// A disk that fails at a chosen moment, and processes that die at one.
#ifndef CAIRN_TESTS_SUPPORT_FAULTY_DISK_H_
#define CAIRN_TESTS_SUPPORT_FAULTY_DISK_H_

#include <cstdint>
#include <functional>
#include <vector>

namespace cairn::testing {

// The fault at SQLite's write number `at_write` (a write, a truncation or a sync), from 1.
struct DiskFault {
  enum class Kind {
    kNone,
    kKill,  // The process dies by SIGKILL with half of the bytes written.
    kFull,  // This and all later writes fail with SQLITE_FULL.
    kCall,  // Calls `call`, then writes.
  };

  Kind kind = Kind::kNone;
  int64_t at_write = 0;
  std::function<void()> call = {};
};

struct ChildResult {
  bool was_killed = false;
  bool has_thrown = false;  // A cairn::Error.
  int64_t num_writes = 0;   // 0 if the process was killed.
};

// Runs `operation` in a child process on a faulty disk. Fails the test if the child ends otherwise
// than by returning, by a cairn::Error or by the fault.
ChildResult RunOnFaultyDisk(const DiskFault& fault, const std::function<void()>& operation);

// `count` random moments of an operation of `num_writes` writes; the first and the last write are
// among them.
std::vector<int64_t> RandomMoments(int64_t num_writes, int count, uint64_t seed);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_FAULTY_DISK_H_
