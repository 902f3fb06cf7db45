#include "storage/tile/tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/angles.h"
#include "core/check.h"
#include "core/error.h"
#include "storage/tile/morton.h"
#include "storage/tile/tile_checks.h"

namespace cairn {
namespace {

constexpr double kTurnRad = 2.0 * kPi;
constexpr double kMinSizeM = 1e-3;
constexpr double kMaxSizeM = 60.0;

// Converts an angle to steps of 1/256 turn, in [0, 256].
double TurnSteps(double angle_rad) {
  CAIRN_CHECK(std::isfinite(angle_rad), "angle must be finite");
  const double turns = angle_rad / kTurnRad;
  return 256.0 * (turns - std::floor(turns));
}

// Returns the nearest angle code that is a multiple of `step`, a power of two.
uint8_t RoundedAngle(double angle_rad, int step) {
  return static_cast<uint8_t>(step * std::lround(TurnSteps(angle_rad) / step) & 255);
}

double AngleFromSteps(uint8_t code) { return kTurnRad / 256.0 * (code <= 128 ? code : code - 256); }

// Returns the nearest code that is a multiple of `step`.
uint8_t LogCode(double value_m, int step) {
  CAIRN_CHECK(!std::isnan(value_m), "size must be a number");
  const double clamped = std::clamp(value_m, kMinSizeM, kMaxSizeM);
  const double code = 255.0 * std::log(clamped / kMinSizeM) / std::log(kMaxSizeM / kMinSizeM);
  return static_cast<uint8_t>(step * std::min<long>(std::lround(code / step), 255 / step));
}

// Powers take as long as the rest of a comparison, and a query needs thousands.
double FromLogCode(uint8_t code) {
  static const std::array<double, 256> kValues = [] {
    std::array<double, 256> values;
    for (int i = 0; i < 256; ++i) {
      values[i] = kMinSizeM * std::pow(kMaxSizeM / kMinSizeM, i / 255.0);
    }
    return values;
  }();
  return kValues[code];
}

template <typename T>
size_t HeapBytes(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

// Returns true if the offsets start at 0, never decrease, and end at `num_values`.
bool AreOffsets(const std::vector<uint32_t>& begin, size_t num_groups, size_t num_values) {
  return begin.size() == num_groups + 1 && begin.front() == 0 && begin.back() == num_values &&
         std::is_sorted(begin.begin(), begin.end());
}

bool IsOnGrid(const Eigen::Vector3f& x_in_tile) {
  for (const float coordinate : x_in_tile) {
    const double steps = coordinate / Tile::kPositionStepM;
    if (!(steps >= -kMaxPositionSteps && steps < kMaxPositionSteps) || steps != std::floor(steps)) {
      return false;
    }
  }
  return true;
}

std::string FindCovisibilityProblem(const Tile& tile) {
  if (!AreOffsets(tile.keyframe_begin, tile.num_keyframes(), tile.keyframe_landmarks.size())) {
    return "the offsets of keyframe_landmarks are inconsistent";
  }
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const std::span<const uint32_t> landmarks = tile.LandmarksOfKeyframe(k);
    if (!landmarks.empty() && landmarks.back() >= tile.num_landmarks()) {
      return "keyframe " + std::to_string(k) + " refers to a missing landmark";
    }
    if (std::adjacent_find(landmarks.begin(), landmarks.end(), std::greater_equal<>()) !=
        landmarks.end()) {
      return "landmarks of keyframe " + std::to_string(k) + " do not ascend";
    }
    if (!IsPose(tile.keyframes[k].cam_from_tile)) {
      return "pose of keyframe " + std::to_string(k) + " is not a rigid transform";
    }
  }
  return "";
}

}  // namespace

bool IsPose(const Rigid3d& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite() &&
         std::abs(pose.rotation.squaredNorm() - 1.0) < 1e-6;
}

std::string FindHistoryProblem(const Tile& tile) {
  if (!AreOffsets(tile.history_begin, tile.num_landmarks(), tile.history.size())) {
    return "offsets of histories do not fit";
  }
  for (size_t i = 0; i < tile.num_landmarks(); ++i) {
    const std::span<const HistoryEntry> history = tile.HistoryOf(i);
    if (history.size() > Tile::kMaxHistory) {
      return "landmark " + std::to_string(i) + " has too many entries in its history";
    }
    for (size_t j = 0; j < history.size(); ++j) {
      if (history[j].num_observations > history[j].num_chances ||
          (j > 0 && history[j].session_id <= history[j - 1].session_id)) {
        return "the history of landmark " + std::to_string(i) + " makes no sense";
      }
    }
  }
  return "";
}

size_t Tile::MemoryBytes() const {
  return HeapBytes(landmark_ids) + HeapBytes(x_in_tile) + HeapBytes(sigma_codes) +
         HeapBytes(descriptor_begin) + HeapBytes(history_begin) + HeapBytes(history) +
         HeapBytes(codes) + HeapBytes(orientation_codes) + HeapBytes(size_codes) +
         HeapBytes(azimuth_codes) + HeapBytes(weight_codes) + HeapBytes(keyframes) +
         HeapBytes(keyframe_begin) + HeapBytes(keyframe_landmarks);
}

std::string FindTileProblem(const Tile& tile) {
  const size_t num_landmarks = tile.num_landmarks();
  const size_t num_descriptors = tile.num_descriptors();
  if (num_landmarks > UINT32_MAX || num_descriptors > UINT32_MAX ||
      tile.num_keyframes() > UINT32_MAX || tile.keyframe_landmarks.size() > UINT32_MAX) {
    return "too large";
  }
  if (tile.landmark_ids.size() != num_landmarks || tile.sigma_codes.size() != num_landmarks) {
    return "arrays of landmarks differ in length";
  }
  if (tile.code_size < 0 || tile.code_size > kMaxCodeSize ||
      (tile.code_size == 0 && num_descriptors > 0)) {
    return "code size " + std::to_string(tile.code_size) + " is out of range";
  }
  if (tile.codes.size() != num_descriptors * tile.code_size ||
      tile.size_codes.size() != num_descriptors || tile.azimuth_codes.size() != num_descriptors ||
      tile.weight_codes.size() != num_descriptors) {
    return "arrays of descriptors differ in length";
  }
  if (!AreOffsets(tile.descriptor_begin, num_landmarks, num_descriptors)) {
    return "the offsets of descriptors are inconsistent";
  }
  if (const std::string problem = FindHistoryProblem(tile); !problem.empty()) {
    return problem;
  }
  const auto off_grid = std::find_if_not(tile.x_in_tile.begin(), tile.x_in_tile.end(), IsOnGrid);
  if (off_grid != tile.x_in_tile.end()) {
    return "position of landmark " + std::to_string(off_grid - tile.x_in_tile.begin()) +
           " is not quantized (see QuantizePosition)";
  }
  return FindCovisibilityProblem(tile);
}

void Tile::Validate() const {
  if (const std::string problem = FindTileProblem(*this); !problem.empty()) {
    throw Error(ErrorCode::kInternal, "tile " + id.ToString() + ": " + problem);
  }
}

uint8_t OrientationCode(double angle_rad) {
  static_assert(kNoOrientation % kOrientationCodeStep != 0);
  return RoundedAngle(angle_rad, kOrientationCodeStep);
}

double OrientationFromCode(uint8_t code) {
  CAIRN_CHECK(code != kNoOrientation, "the code holds no orientation");
  return AngleFromSteps(code);
}

uint8_t AzimuthCode(double azimuth_rad) { return RoundedAngle(azimuth_rad, kAzimuthCodeStep); }

double AzimuthFromCode(uint8_t code) { return AngleFromSteps(code); }

// Writers use only the multiples of kSizeCodeStep for sizes.
constexpr uint8_t kUnknownSizeCode = 255;
static_assert(kUnknownSizeCode % kSizeCodeStep != 0);

uint8_t SizeCode(double size_m) {
  return size_m <= 0.0 ? kUnknownSizeCode : LogCode(size_m, kSizeCodeStep);
}
double SizeFromCode(uint8_t code) { return code == kUnknownSizeCode ? 0.0 : FromLogCode(code); }
uint8_t SigmaCode(double sigma_m) { return LogCode(sigma_m, 1); }
double SigmaFromCode(uint8_t code) { return FromLogCode(code); }

uint8_t WeightCode(double num_observations) {
  return static_cast<uint8_t>(std::lround(std::clamp(4.0 * num_observations, 1.0, 255.0)));
}
double WeightFromCode(uint8_t code) { return code / 4.0; }

Eigen::Vector3f QuantizePosition(const Eigen::Vector3d& x_in_tile) {
  CAIRN_CHECK(x_in_tile.allFinite(), "position must be finite");
  Eigen::Vector3f quantized;
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = std::round(x_in_tile[axis] / Tile::kPositionStepM);
    const double clamped = std::clamp<double>(steps, -kMaxPositionSteps, kMaxPositionSteps - 1);
    quantized[axis] = static_cast<float>(clamped * Tile::kPositionStepM);
  }
  return quantized;
}

std::vector<uint32_t> MortonOrder(std::span<const Eigen::Vector3f> x_in_tile) {
  std::vector<uint64_t> codes(x_in_tile.size());
  std::transform(x_in_tile.begin(), x_in_tile.end(), codes.begin(), MortonFromPosition);
  std::vector<uint32_t> order(x_in_tile.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&codes](uint32_t a, uint32_t b) {
    return codes[a] != codes[b] ? codes[a] < codes[b] : a < b;
  });
  return order;
}

}  // namespace cairn
