#include "core/available_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "support/temp_dir.h"

namespace cairn {
namespace {

class AvailableMemory : public ::testing::Test {
 protected:
  void Write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = dir_.path() / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::optional<uint64_t> Available() const { return AvailableMemoryBytes(dir_.path().string()); }

 private:
  testing::TempDir dir_;
};

constexpr char kMemInfo[] =
    "MemTotal:       24696916 kB\nMemFree:         1000 kB\nMemAvailable:    2000 kB\nSwapFree: "
    "100 kB\n";

TEST_F(AvailableMemory, IsWhatTheMachineHasFree) {
  Write("proc/meminfo", kMemInfo);
  EXPECT_EQ(Available(), 2100u * 1024u);
}

TEST_F(AvailableMemory, IsTheLeastLimitOfTheGroups) {
  Write("proc/meminfo", kMemInfo);
  Write("proc/self/cgroup", "0::/user.slice/a.service\n");
  Write("sys/fs/cgroup/user.slice/memory.max", "3000000\n");
  Write("sys/fs/cgroup/user.slice/a.service/memory.max", "max\n");
  EXPECT_EQ(Available(), 2100u * 1024u);
  Write("sys/fs/cgroup/user.slice/a.service/memory.max", "1000000\n");
  EXPECT_EQ(Available(), 1000000u);
}

TEST_F(AvailableMemory, ReadsGroupsOfTheFirstVersion) {
  Write("proc/meminfo", kMemInfo);
  Write("proc/self/cgroup", "9:name=systemd:/\n5:hugetlb,memory:/docker/abc\n4:cpu,cpuacct:/\n");
  Write("sys/fs/cgroup/memory/memory.limit_in_bytes", "500000\n");  // As a container sees it.
  EXPECT_EQ(Available(), 500000u);
}

TEST_F(AvailableMemory, IsUnknownIfNothingTells) {
  EXPECT_FALSE(Available());
  Write("proc/meminfo", "nonsense\n");
  Write("proc/self/cgroup", "nonsense");
  EXPECT_FALSE(Available());
}

TEST(AvailableMemoryOfThisMachine, IsKnown) {
  if (!std::filesystem::exists("/proc/meminfo")) {
    GTEST_SKIP() << "/proc is not mounted";
  }
  EXPECT_GT(AvailableMemoryBytes(), 1u << 20);
}

}  // namespace
}  // namespace cairn
