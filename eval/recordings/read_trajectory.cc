#include "eval/recordings/read_trajectory.h"

#include <array>
#include <charconv>
#include <fstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn::fusion {
namespace {

constexpr int64_t kMaxGapNs = 60'000'000;  // Poses at 20 Hz are about 50 ms apart.

// A line of the file: a timestamp and kNumValues numbers.
template <size_t kNumValues>
struct Row {
  int64_t timestamp_ns = 0;
  std::array<double, kNumValues> values{};
};

template <typename Number>
bool ReadNumber(std::string_view* text, Number* number) {
  text->remove_prefix(std::min(text->find_first_not_of(", \t"), text->size()));
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), *number);
  text->remove_prefix(static_cast<size_t>(end - text->data()));
  return error == std::errc();
}

template <size_t kNumValues>
std::vector<Row<kNumValues>> ReadRows(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw Error(ErrorCode::kNotFound, path + ": cannot be read");
  }
  std::vector<Row<kNumValues>> rows;
  std::string line;
  for (int line_number = 1; std::getline(file, line); ++line_number) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    std::string_view text = line;
    Row<kNumValues> row;
    bool is_good = ReadNumber(&text, &row.timestamp_ns);
    for (double& value : row.values) {
      is_good = is_good && ReadNumber(&text, &value);
    }
    if (!is_good || (!rows.empty() && row.timestamp_ns <= rows.back().timestamp_ns)) {
      throw Error(ErrorCode::kBadInput, path + ":" + std::to_string(line_number) +
                                            ": expected a later timestamp and " +
                                            std::to_string(kNumValues) + " numbers");
    }
    rows.push_back(row);
  }
  return rows;
}

// Returns [first, last) of the longest stretch without gaps.
std::pair<size_t, size_t> LongestStretch(const std::vector<TruePose>& poses) {
  std::pair<size_t, size_t> longest = {0, 0};
  size_t begin = 0;
  for (size_t i = 1; i <= poses.size(); ++i) {
    if (i == poses.size() || poses[i].timestamp_ns - poses[i - 1].timestamp_ns > kMaxGapNs) {
      if (i - begin > longest.second - longest.first) {
        longest = {begin, i};
      }
      begin = i;
    }
  }
  return longest;
}

}  // namespace

Trajectory ReadTrajectory(const std::string& name, const std::string& imu_path,
                          const std::string& poses_path, const ImuNoise& imu_noise) {
  Trajectory trajectory;
  trajectory.name = name;
  for (const Row<6>& row : ReadRows<6>(imu_path)) {
    const auto& v = row.values;
    trajectory.imu.push_back({row.timestamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  }
  std::vector<TruePose> poses;
  for (const Row<7>& row : ReadRows<7>(poses_path)) {
    const auto& v = row.values;
    poses.push_back({row.timestamp_ns, Rigid3d(Eigen::Quaterniond(v[3], v[4], v[5], v[6]),
                                               Eigen::Vector3d(v[0], v[1], v[2]))});
  }
  const auto [first, last] = LongestStretch(poses);
  trajectory.poses.assign(poses.begin() + static_cast<std::ptrdiff_t>(first),
                          poses.begin() + static_cast<std::ptrdiff_t>(last));
  FitToSamples(&trajectory);
  SmoothPoses({}, imu_noise, &trajectory);
  return trajectory;
}

}  // namespace cairn::fusion
