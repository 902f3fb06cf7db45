#include "ingest/colmap/descriptor_information.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

constexpr size_t kLeastRows = 20;
constexpr size_t kMaxPairs = 1000;
constexpr size_t kLeastPairs = 50;
constexpr double kLeastShareNearer = 0.75;

// Descriptors of one landmark in its first and in its last image.
struct Pair {
  Eigen::VectorXf first, last;
};

Eigen::VectorXf DescriptorOf(const Reconstruction& reconstruction, const ReconObservation& seen) {
  return reconstruction.images[seen.image_idx].features.descriptors.Row(seen.keypoint_idx);
}

std::vector<Pair> SamplePairs(const Reconstruction& reconstruction) {
  const size_t step = 1 + reconstruction.landmarks.size() / kMaxPairs;
  std::vector<Pair> pairs;
  for (size_t i = 0; i < reconstruction.landmarks.size(); i += step) {
    const std::vector<ReconObservation>& seen = reconstruction.landmarks[i].observations;
    pairs.push_back(
        {DescriptorOf(reconstruction, seen.front()), DescriptorOf(reconstruction, seen.back())});
  }
  return pairs;
}

}  // namespace

void RequireVariedDescriptors(const std::string& image_name, std::span<const uint8_t> rows,
                              int dim) {
  const auto row_bytes = static_cast<size_t>(dim);
  const size_t num_rows = rows.size() / row_bytes;
  if (num_rows < kLeastRows) {
    return;
  }
  size_t num_zero = 0, num_equal = 0;
  for (size_t i = 0; i < num_rows; ++i) {
    const auto row = rows.subspan(i * row_bytes, row_bytes);
    num_zero += std::ranges::all_of(row, [](uint8_t value) { return value == 0; }) ? 1 : 0;
    num_equal += std::memcmp(row.data(), rows.data(), row_bytes) == 0 ? 1 : 0;
  }
  if (2 * std::max(num_zero, num_equal) > num_rows) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} of the {} descriptors of image {} are {}, so they carry no "
                            "information; extract features again",
                            std::max(num_zero, num_equal), num_rows, Excerpt(image_name),
                            num_zero > 0 ? "zero" : "equal"));
  }
}

void RequireInformation(const Reconstruction& reconstruction) {
  const std::vector<Pair> pairs = SamplePairs(reconstruction);
  if (pairs.size() < kLeastPairs) {
    return;
  }
  double num_nearer = 0.0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    // Half of the sample away, since neighbors in the list are often neighbors in space.
    const Pair& other = pairs[(i + pairs.size() / 2) % pairs.size()];
    const float same = (pairs[i].first - pairs[i].last).squaredNorm();
    const float different = (pairs[i].first - other.last).squaredNorm();
    num_nearer += same < different ? 1.0 : same == different ? 0.5 : 0.0;
  }
  const double share = num_nearer / static_cast<double>(pairs.size());
  if (share < kLeastShareNearer) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("the descriptors do not tell landmarks apart: those of one landmark in two "
                    "images are nearer to each other than to others in only {:.0f} % of the cases "
                    "(50 % is chance); check that they belong to the keypoints of the model, or "
                    "extract features again",
                    100.0 * share));
  }
}

}  // namespace cairn
