#include "core/geoid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "core/error.h"

namespace cairn {
namespace {

// A GTX file is big-endian. It holds the latitude and longitude of the south-west corner and the
// two steps as doubles, the numbers of rows and columns as int32, and the heights as float32, rows
// from south to north.
constexpr size_t kHeaderBytes = 4 * 8 + 2 * 4;
constexpr int kMaxSide = 100'000;

template <typename Value, typename Bits>
Value BigEndian(const char* bytes) {
  Bits bits = 0;
  for (size_t i = 0; i < sizeof(Bits); ++i) {
    bits = static_cast<Bits>(bits << 8 | static_cast<uint8_t>(bytes[i]));
  }
  return std::bit_cast<Value>(bits);
}

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file || bytes.empty()) {
    throw Error(
        ErrorCode::kUnavailable,
        fmt::format("{}: cannot be read, and without it heights above mean sea level cannot "
                    "be converted; install the package proj-data, or give heights above "
                    "the ellipsoid",
                    path));
  }
  return bytes;
}

// Returns the weights of four neighbors (Catmull-Rom) at fraction `t` of the step after the second
// neighbor.
std::array<double, 4> CubicWeights(double t) {
  return {0.5 * t * (-1.0 + t * (2.0 - t)), 1.0 + 0.5 * t * t * (-5.0 + 3.0 * t),
          0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
}

}  // namespace

const char* HeightReferenceName(HeightReference reference) {
  return reference == HeightReference::kEllipsoid ? "ellipsoid" : "msl";
}

std::optional<HeightReference> HeightReferenceFromName(std::string_view name) {
  for (const HeightReference reference :
       {HeightReference::kEllipsoid, HeightReference::kMeanSeaLevel}) {
    if (name == HeightReferenceName(reference)) {
      return reference;
    }
  }
  return std::nullopt;
}

Geoid::Geoid(const std::string& gtx_path) {
  const std::string bytes = ReadFile(gtx_path);
  const auto fail = [&](const char* what) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: is not a global GTX grid: {}", gtx_path, what));
  };
  if (bytes.size() < kHeaderBytes) {
    fail("it ends within its header");
  }
  const auto number = [&](size_t at) { return BigEndian<double, uint64_t>(bytes.data() + at); };
  const double south_deg = number(0);
  west_deg_ = number(8);
  step_deg_ = number(24);
  num_rows_ = BigEndian<int32_t, uint32_t>(bytes.data() + 32);
  num_columns_ = BigEndian<int32_t, uint32_t>(bytes.data() + 36);
  const bool has_size = num_rows_ >= 4 && num_columns_ >= 4 && num_rows_ < kMaxSide &&
                        num_columns_ < kMaxSide &&
                        bytes.size() == kHeaderBytes + sizeof(float) * num_rows_ * num_columns_;
  if (!has_size) {
    fail("its length does not match its header");
  }
  const bool is_global = south_deg == -90.0 && number(16) == step_deg_ &&
                         step_deg_ * (num_rows_ - 1) == 180.0 && step_deg_ * num_columns_ == 360.0;
  if (!is_global || num_columns_ % 2 != 0) {
    fail("it does not cover the Earth exactly once");
  }
  heights_m_.resize(static_cast<size_t>(num_rows_) * num_columns_);
  for (size_t i = 0; i < heights_m_.size(); ++i) {
    heights_m_[i] = BigEndian<float, uint32_t>(bytes.data() + kHeaderBytes + sizeof(float) * i);
  }
}

const Geoid& Geoid::Egm96() {
  static const Geoid geoid(CAIRN_EGM96_GRID);
  return geoid;
}

// Beyond a pole, a meridian continues on the other side of the Earth.
double Geoid::At(int row, int column) const {
  if (row < 0 || row >= num_rows_) {
    row = row < 0 ? -row : 2 * (num_rows_ - 1) - row;
    column += num_columns_ / 2;
  }
  column = (column % num_columns_ + num_columns_) % num_columns_;
  return heights_m_[static_cast<size_t>(row) * num_columns_ + column];
}

double Geoid::HeightM(double lat_rad, double lon_rad) const {
  const Geodetic place{lat_rad, lon_rad, 0.0};
  const double y = std::clamp((place.lat_deg() + 90.0) / step_deg_, 0.0, num_rows_ - 1.0);
  const double x = (place.lon_deg() - west_deg_) / step_deg_;
  const int row = static_cast<int>(std::floor(y));
  const int column = static_cast<int>(std::floor(x));
  const std::array<double, 4> row_weights = CubicWeights(y - row);
  const std::array<double, 4> column_weights = CubicWeights(x - column);
  double height_m = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      height_m += row_weights[i] * column_weights[j] * At(row + i - 1, column + j - 1);
    }
  }
  return height_m;
}

Geodetic WithEllipsoidalHeight(const Geodetic& position, HeightReference reference) {
  Geodetic ellipsoidal = position;
  if (reference == HeightReference::kMeanSeaLevel) {
    ellipsoidal.h_m += Geoid::Egm96().HeightM(position.lat_rad, position.lon_rad);
  }
  return ellipsoidal;
}

}  // namespace cairn
