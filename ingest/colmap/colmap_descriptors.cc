#include "ingest/colmap/colmap_descriptors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace cairn {
namespace {

constexpr int kMinRows = 100;
constexpr size_t kMaxRowsAtOnce = 100;
// Half way between the two normalizations; see SiftStatistics.
constexpr double kEvennessBetween = 0.72;
// COLMAP gives every row the length 512, up to rounding. A row clipped at 255 is shorter.
constexpr double kMinLength = 420.0, kMaxLength = 560.0;

// The name of a value of COLMAP's FeatureExtractorType.
std::string TypeName(int64_t type) {
  switch (type) {
    case 0:
      return "SIFT";
    case 1:
      return "ALIKED_N16ROT";
    case 2:
      return "ALIKED_N32";
    default:
      return fmt::format("of COLMAP's type {}", type);
  }
}

[[noreturn]] void Refuse(const std::string& image_name, const std::string& what) {
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("the descriptors of image {} are {}; only SIFT is supported: extract with "
                  "COLMAP's SIFT, which stores {} bytes per keypoint",
                  image_name.substr(0, 100), what, kColmapDim));
}

}  // namespace

void CheckSiftBlob(const std::string& image_name, std::optional<int64_t> type, int64_t rows,
                   int64_t cols, uint64_t num_bytes) {
  constexpr int64_t kSift = 0, kUndefined = -1;
  if (type && *type != kSift && *type != kUndefined) {
    Refuse(image_name, TypeName(*type));
  }
  const auto num_numbers = static_cast<uint64_t>(rows) * static_cast<uint64_t>(cols);
  if (rows > 0 && num_bytes == 4 * num_numbers) {
    Refuse(image_name, fmt::format("floats of {} dimensions", cols));
  }
  if (rows > 0 && cols != kColmapDim) {
    Refuse(image_name, cols % 4 == 0 && cols > kColmapDim
                           ? fmt::format("{} bytes per keypoint, probably floats of {} dimensions",
                                         cols, cols / 4)
                           : fmt::format("{} bytes per keypoint", cols));
  }
}

void SiftStatistics::Add(std::span<const uint8_t> rows) {
  const size_t num_rows = rows.size() / kColmapDim;
  const size_t step = std::max<size_t>(1, num_rows / kMaxRowsAtOnce);
  for (size_t i = 0; i < num_rows; i += step) {
    double sum = 0.0, sum_squares = 0.0;
    int num_set = 0;
    for (const uint8_t value : rows.subspan(i * kColmapDim, kColmapDim)) {
      sum += value;
      sum_squares += static_cast<double>(value) * value;
      num_set += value != 0 ? 1 : 0;
    }
    if (num_set == 0) {
      continue;
    }
    ++num_rows_;
    sum_evenness_ += sum / std::sqrt(sum_squares * num_set);
    sum_length_ += std::sqrt(sum_squares);
  }
}

SiftNormalization SiftStatistics::Normalization() const {
  if (num_rows_ < kMinRows) {
    return SiftNormalization::kL1Root;
  }
  const double length = sum_length_ / num_rows_;
  if (!(length >= kMinLength && length <= kMaxLength)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("its descriptors are not SIFT: their mean length is {:.0f} instead of the "
                    "512 that COLMAP writes",
                    length));
  }
  return sum_evenness_ / num_rows_ < kEvennessBetween ? SiftNormalization::kL2
                                                      : SiftNormalization::kL1Root;
}

}  // namespace cairn
