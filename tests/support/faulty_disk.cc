#include "support/faulty_disk.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <list>
#include <random>

#include "core/error.h"

namespace cairn::testing {
namespace {

// One per kind of file that SQLite knows; the methods come first, so that a pointer to them is a
// pointer to this.
struct Methods {
  sqlite3_io_methods faulty;
  const sqlite3_io_methods* sound;
};

// Of the child process, which runs one operation.
struct State {
  DiskFault fault;
  int64_t num_writes = 0;
  sqlite3_vfs* sound_vfs = nullptr;
  sqlite3_vfs faulty_vfs = {};
  std::list<Methods> methods;
} state;

const sqlite3_io_methods* SoundMethods(sqlite3_file* file) {
  return reinterpret_cast<const Methods*>(file->pMethods)->sound;
}

// Counts a write. Returns SQLITE_OK if it is to be done. `dying` does a part of it.
int CountWrite(const std::function<void()>& dying) {
  ++state.num_writes;
  if (state.fault.kind == DiskFault::Kind::kFull && state.num_writes >= state.fault.at_write) {
    return SQLITE_FULL;
  }
  if (state.num_writes == state.fault.at_write) {
    if (state.fault.kind == DiskFault::Kind::kKill) {
      dying();
      raise(SIGKILL);
    }
    if (state.fault.kind == DiskFault::Kind::kCall) {
      state.fault.call();
    }
  }
  return SQLITE_OK;
}

int Write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
  const sqlite3_io_methods* sound = SoundMethods(file);
  const int result = CountWrite([&] { sound->xWrite(file, bytes, size / 2, offset); });
  return result == SQLITE_OK ? sound->xWrite(file, bytes, size, offset) : result;
}

int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  const int result = CountWrite([] {});
  return result == SQLITE_OK ? SoundMethods(file)->xTruncate(file, size) : result;
}

int Sync(sqlite3_file* file, int flags) {
  const int result = CountWrite([] {});
  return result == SQLITE_OK ? SoundMethods(file)->xSync(file, flags) : result;
}

int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  const int result = state.sound_vfs->xOpen(state.sound_vfs, name, file, flags, out_flags);
  if (file->pMethods != nullptr) {
    state.methods.push_back({*file->pMethods, file->pMethods});
    sqlite3_io_methods& faulty = state.methods.back().faulty;
    faulty.xWrite = &Write;
    faulty.xTruncate = &Truncate;
    faulty.xSync = &Sync;
    file->pMethods = &faulty;
  }
  return result;
}

void InstallFault(const DiskFault& fault) {
  state.fault = fault;
  state.sound_vfs = sqlite3_vfs_find(nullptr);
  state.faulty_vfs = *state.sound_vfs;
  state.faulty_vfs.zName = "faulty";
  state.faulty_vfs.pNext = nullptr;
  state.faulty_vfs.xOpen = &Open;
  sqlite3_vfs_register(&state.faulty_vfs, 1);
}

struct Message {
  bool has_thrown = false;
  int64_t num_writes = 0;
};

[[noreturn]] void RunChild(const DiskFault& fault, const std::function<void()>& operation,
                           int pipe_fd) {
  Message message;
  try {
    InstallFault(fault);
    operation();
  } catch (const Error& error) {
    message.has_thrown = true;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "the child process threw: %s\n", error.what());
    _exit(1);
  }
  message.num_writes = state.num_writes;
  _exit(write(pipe_fd, &message, sizeof(message)) == sizeof(message) ? 0 : 1);
}

}  // namespace

ChildResult RunOnFaultyDisk(const DiskFault& fault, const std::function<void()>& operation) {
  int fds[2];
  EXPECT_EQ(pipe(fds), 0);
  const pid_t child = fork();
  if (child == 0) {
    RunChild(fault, operation, fds[1]);
  }
  close(fds[1]);
  ChildResult result;
  Message message;
  if (read(fds[0], &message, sizeof(message)) == sizeof(message)) {
    result.has_thrown = message.has_thrown;
    result.num_writes = message.num_writes;
  }
  close(fds[0]);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  result.was_killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  EXPECT_TRUE(result.was_killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0));
  return result;
}

std::vector<int64_t> RandomMoments(int64_t num_writes, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<int64_t> moments = {1, num_writes};
  while (std::ssize(moments) < count) {
    moments.push_back(1 + static_cast<int64_t>(random() % static_cast<uint64_t>(num_writes)));
  }
  return moments;
}

}  // namespace cairn::testing
