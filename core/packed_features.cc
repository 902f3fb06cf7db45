#include "core/packed_features.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace cairn {
namespace {

bool AreBytes(const DescriptorMatrix& values) {
  return std::all_of(values.data(), values.data() + values.size(), [](float value) {
    return value >= 0.0f && value <= 255.0f && value == std::floor(value) && !std::signbit(value);
  });
}

template <typename Matrix>
Matrix RowsOf(const Matrix& values, std::span<const int> rows) {
  Matrix chosen(static_cast<Eigen::Index>(rows.size()), values.cols());
  for (size_t i = 0; i < rows.size(); ++i) {
    chosen.row(static_cast<Eigen::Index>(i)) = values.row(rows[i]);
  }
  return chosen;
}

template <typename Bytes>
DescriptorMatrix ValuesOf(const Bytes& bytes, const std::vector<float>& value_of_byte) {
  if (value_of_byte.empty()) {
    return bytes.template cast<float>();
  }
  return bytes.unaryExpr([&](uint8_t byte) { return value_of_byte[byte]; });
}

}  // namespace

PackedDescriptors::PackedDescriptors(const DescriptorMatrix& values) {
  if (AreBytes(values)) {
    values_ = StoredDescriptors(values.cast<uint8_t>());
  } else {
    values_ = values;
  }
}

PackedDescriptors::PackedDescriptors(ByteDescriptorMatrix bytes, std::vector<float> value_of_byte) {
  CAIRN_CHECK(value_of_byte.size() == 256, "a byte has 256 values");
  // The same values are packed in the same way, wherever they come from.
  if (const DescriptorMatrix values = ValuesOf(bytes, value_of_byte); AreBytes(values)) {
    values_ = StoredDescriptors(values.cast<uint8_t>());
  } else {
    values_ = StoredDescriptors(std::move(bytes));
    value_of_byte_ = std::move(value_of_byte);
  }
}

Eigen::Index PackedDescriptors::rows() const {
  return std::visit([](const auto& values) { return values.rows(); }, values_);
}

Eigen::Index PackedDescriptors::cols() const {
  return std::visit([](const auto& values) { return values.cols(); }, values_);
}

const StoredDescriptors* PackedDescriptors::as_bytes() const {
  return value_of_byte_.empty() ? std::get_if<StoredDescriptors>(&values_) : nullptr;
}

Eigen::RowVectorXf PackedDescriptors::Row(Eigen::Index row) const {
  if (const auto* floats = std::get_if<DescriptorMatrix>(&values_)) {
    return floats->row(row);
  }
  return ValuesOf(std::get<StoredDescriptors>(values_).Row(row), value_of_byte_);
}

PackedDescriptors PackedDescriptors::Rows(std::span<const int> rows) const {
  if (const auto* floats = std::get_if<DescriptorMatrix>(&values_)) {
    return RowsOf(*floats, rows);
  }
  ByteDescriptorMatrix chosen = RowsOf(*std::get<StoredDescriptors>(values_).Load(), rows);
  return value_of_byte_.empty() ? PackedDescriptors(std::move(chosen))
                                : PackedDescriptors(std::move(chosen), value_of_byte_);
}

DescriptorMatrix PackedDescriptors::Unpacked() const {
  if (const auto* floats = std::get_if<DescriptorMatrix>(&values_)) {
    return *floats;
  }
  return ValuesOf(*std::get<StoredDescriptors>(values_).Load(), value_of_byte_);
}

PackedFeatures::PackedFeatures(FeatureSet features)
    : keypoints(std::move(features.keypoints)),
      descriptors(features.descriptors),
      space(features.space) {}

FeatureSet PackedFeatures::Unpacked() const {
  return {.keypoints = keypoints, .descriptors = descriptors.Unpacked(), .space = space};
}

void ValidateFeatures(const PackedFeatures& features, const char* what) {
  ValidateFeatures(features.Unpacked(), what);
}

}  // namespace cairn
