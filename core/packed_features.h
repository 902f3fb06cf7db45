// Features that are kept for many images at a time: a value of a descriptor takes a byte where it
// can, instead of the four of a FeatureSet.
#ifndef CAIRN_CORE_PACKED_FEATURES_H_
#define CAIRN_CORE_PACKED_FEATURES_H_

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/features.h"
#include "core/stored_descriptors.h"

namespace cairn {

// num_features x descriptor_dim numbers, exactly those that were put in. Bytes may be on disk:
// StoredDescriptors.
class PackedDescriptors {
 public:
  PackedDescriptors() = default;
  // A byte a value if all are whole numbers up to 255, as those of SIFT are; else a float.
  PackedDescriptors(const DescriptorMatrix& values);
  // Each byte is its own value.
  explicit PackedDescriptors(StoredDescriptors bytes) : values_(std::move(bytes)) {}
  explicit PackedDescriptors(ByteDescriptorMatrix bytes)
      : PackedDescriptors(StoredDescriptors(std::move(bytes))) {}
  // Byte b stands for value_of_byte[b]; there are 256.
  PackedDescriptors(ByteDescriptorMatrix bytes, std::vector<float> value_of_byte);

  Eigen::Index rows() const;
  Eigen::Index cols() const;

  // The values, or null if some are not whole numbers up to 255, or are -0.
  const StoredDescriptors* as_bytes() const;
  Eigen::RowVectorXf Row(Eigen::Index row) const;
  PackedDescriptors Rows(std::span<const int> rows) const;
  DescriptorMatrix Unpacked() const;

 private:
  std::variant<StoredDescriptors, DescriptorMatrix> values_;
  std::vector<float> value_of_byte_;  // Empty if each byte is its own value.
};

// A FeatureSet, packed.
struct PackedFeatures {
  PackedFeatures() = default;
  PackedFeatures(FeatureSet features);

  std::vector<Keypoint> keypoints;
  PackedDescriptors descriptors;  // A row a keypoint.
  DescriptorSpace space = DescriptorSpace::kRaw;

  int size() const { return static_cast<int>(keypoints.size()); }
  FeatureSet Unpacked() const;
};

// As for a FeatureSet.
void ValidateFeatures(const PackedFeatures& features, const char* what);

}  // namespace cairn

#endif  // CAIRN_CORE_PACKED_FEATURES_H_
