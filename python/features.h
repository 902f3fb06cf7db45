// cairn.Features: keypoints and descriptors that Python and queries share.
#ifndef CAIRN_PYTHON_FEATURES_H_
#define CAIRN_PYTHON_FEATURES_H_

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "core/features.h"
#include "python/errors.h"

namespace cairn::python {

// Immutable, so that numpy may look at the elements at any time. Safe to use from any thread.
class StoredFeatures {
 public:
  // `type` names an extractor, or the codec of a map for projected descriptors. `image_size_px` is
  // that of the picture that the keypoints lie in, if known.
  StoredFeatures(FeatureSet features, std::string type,
                 std::optional<std::array<int, 2>> image_size_px);

  int size() const { return size_; }
  int descriptor_dim() const { return descriptor_dim_; }
  const Keypoint* keypoints() const { return keypoints_; }
  const float* descriptors() const { return descriptors_; }  // size x descriptor_dim.
  const std::string& type() const { return type_; }
  bool is_projected() const { return space_ == DescriptorSpace::kProjected; }
  const std::optional<std::array<int, 2>>& image_size_px() const { return image_size_px_; }

 private:
  friend class FeatureLoan;

  FeatureSet features_;  // Empty while it is lent.
  std::atomic<bool> is_lent_ = false;
  // The elements stay where they are while the set is moved.
  int size_;
  int descriptor_dim_;
  const Keypoint* keypoints_;
  const float* descriptors_;
  DescriptorSpace space_;
  std::string type_;
  std::optional<std::array<int, 2>> image_size_px_;
};

// Moves features into a query for as long as it lives, because a query owns its features and a copy
// of a megabyte would take as long as the binding may. If another query has them, copies them.
class FeatureLoan {
 public:
  FeatureLoan(const std::shared_ptr<StoredFeatures>& from, FeatureSet* to);
  ~FeatureLoan();
  FeatureLoan(const FeatureLoan&) = delete;
  FeatureLoan& operator=(const FeatureLoan&) = delete;

 private:
  std::shared_ptr<StoredFeatures> from_;  // Null if the features were copied.
  FeatureSet* to_;
};

// True for the name of a codec of projected descriptors, as "sift-128-16-1" (Codebook::CodecName).
bool IsCodecName(const std::string& type);

void BindFeatures(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_FEATURES_H_
