#include "python/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/keypoint_shape.h"
#include "python/arguments.h"
#include "python/arrays.h"
#include "python/camera.h"
#include "python/camera_input.h"
#include "python/docs.h"

namespace cairn::python {
namespace {

static_assert(sizeof(Keypoint) == 4 * sizeof(float), "keypoints are rows of four floats");

template <typename T>
std::vector<Keypoint> KeypointsOf(const py::array& array) {
  const auto num_columns = array.shape(1);
  std::vector<Keypoint> keypoints(static_cast<size_t>(array.shape(0)));
  const T* row = static_cast<const T*>(array.data());
  for (Keypoint& keypoint : keypoints) {
    keypoint = KeypointWithoutShape(static_cast<float>(row[0]), static_cast<float>(row[1]));
    if (num_columns == 4) {
      keypoint.scale_px = static_cast<float>(row[2]);
      keypoint.orientation_rad = static_cast<float>(row[3]);
    }
    row += num_columns;
  }
  return keypoints;
}

std::vector<Keypoint> KeypointsOf(py::handle value) {
  const py::array array = RequireArray("keypoints", value);
  const bool has_shape = array.ndim() == 2 && (array.shape(1) == 2 || array.shape(1) == 4);
  if (has_shape && HoldsA<float>(array)) {
    return KeypointsOf<float>(array);
  }
  if (has_shape && HoldsA<double>(array)) {
    return KeypointsOf<double>(array);
  }
  RefuseArgument("keypoints", DescribeArray(array) +
                                  "; must be float32 or float64 of shape (N, 2), or (N, 4) with "
                                  "scale and orientation");
}

template <typename T>
DescriptorMatrix DescriptorsOf(const py::array& array) {
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Matrix>(static_cast<const T*>(array.data()), array.shape(0),
                                  array.shape(1))
      .template cast<float>();
}

DescriptorMatrix DescriptorsOf(py::handle value) {
  const py::array array = RequireArray("descriptors", value);
  if (array.ndim() == 2 && HoldsA<float>(array)) {
    return DescriptorsOf<float>(array);
  }
  if (array.ndim() == 2 && HoldsA<uint8_t>(array)) {
    return DescriptorsOf<uint8_t>(array);
  }
  RefuseArgument("descriptors",
                 DescribeArray(array) + "; must be float32 or uint8 of shape (N, D)");
}

std::shared_ptr<StoredFeatures> MakeFeatures(const py::object& keypoints,
                                             const py::object& descriptors, const py::object& type,
                                             const py::object& size) {
  FeatureSet features;
  features.keypoints = KeypointsOf(keypoints);
  features.descriptors = DescriptorsOf(descriptors);
  const std::string type_name = TextOf("type", type);
  features.space = IsCodecName(type_name) ? DescriptorSpace::kProjected : DescriptorSpace::kRaw;
  if (static_cast<Eigen::Index>(features.keypoints.size()) != features.descriptors.rows()) {
    RefuseArgument("descriptors",
                   fmt::format("{} rows for {} keypoints", features.descriptors.rows(),
                               features.keypoints.size()));
  }
  try {
    ValidateFeatures(features, "keypoints, descriptors");
  } catch (const Error& error) {
    throw Error(ErrorCode::kInvalidArgument, error.what());
  }
  std::optional<std::array<int, 2>> image_size_px;
  if (!size.is_none()) {
    image_size_px = SizeOf("size", size);
  }
  return std::make_shared<StoredFeatures>(std::move(features), type_name, image_size_px);
}

std::shared_ptr<StoredFeatures> Extract(const py::object& image, const py::object& camera_argument,
                                        const py::object& type, const py::object& options) {
  if (TextOf("type", type) != "sift") {
    RefuseArgument("type", "cairn extracts 'sift'; make cairn.Features of other features");
  }
  const CameraInput input = CameraInputOf("image", image);
  if (input.features) {
    RefuseArgument("image", "must be a picture, not features");
  }
  const std::optional<StatedCamera> camera = CameraOf("camera", camera_argument);
  const SiftExtractor extractor(OptionsOf(options).sift);
  const py::gil_scoped_release release;
  const Picture picture = ReadPicture(input, camera ? &camera->camera : nullptr);
  return std::make_shared<StoredFeatures>(
      extractor.Extract(picture.image), extractor.descriptor_type(),
      std::array{picture.image.picture_width_px(), picture.image.picture_height_px()});
}

py::object SizeOrNone(const StoredFeatures& features) {
  const auto& size = features.image_size_px();
  return size ? py::object(py::make_tuple((*size)[0], (*size)[1])) : py::none();
}

}  // namespace

StoredFeatures::StoredFeatures(FeatureSet features, std::string type,
                               std::optional<std::array<int, 2>> image_size_px)
    : features_(std::move(features)),
      size_(features_.size()),
      descriptor_dim_(static_cast<int>(features_.descriptors.cols())),
      keypoints_(features_.keypoints.data()),
      descriptors_(features_.descriptors.data()),
      space_(features_.space),
      type_(std::move(type)),
      image_size_px_(image_size_px) {}

FeatureLoan::FeatureLoan(const std::shared_ptr<StoredFeatures>& from, FeatureSet* to) : to_(to) {
  if (!from->is_lent_.exchange(true)) {
    from_ = from;
    std::swap(*to_, from_->features_);
    return;
  }
  to_->keypoints.assign(from->keypoints(), from->keypoints() + from->size());
  to_->descriptors =
      Eigen::Map<const DescriptorMatrix>(from->descriptors(), from->size(), from->descriptor_dim());
  to_->space = from->space_;
}

FeatureLoan::~FeatureLoan() {
  if (from_) {
    std::swap(*to_, from_->features_);
    from_->is_lent_ = false;
  }
}

bool IsCodecName(const std::string& type) {
  // An extractor and three numbers, each after a dash.
  size_t end = type.size();
  for (int part = 0; part < 3; ++part) {
    const size_t dash = type.find_last_of('-', end == 0 ? 0 : end - 1);
    if (dash == std::string::npos || dash == 0 || dash + 1 == end ||
        type.find_first_not_of("0123456789", dash + 1) < end) {
      return false;
    }
    end = dash;
  }
  return true;
}

void BindFeatures(py::module_* module) {
  using py::arg;
  py::class_<StoredFeatures, std::shared_ptr<StoredFeatures>>(*module, "Features", docs::kFeatures)
      .def(py::init(&MakeFeatures), arg("keypoints"), arg("descriptors"), arg("type") = "sift",
           arg("size") = py::none())
      .def_property_readonly(
          "keypoints",
          [](const py::object& self) {
            const auto& features = self.cast<const StoredFeatures&>();
            return ViewOf(reinterpret_cast<const float*>(features.keypoints()),
                          {features.size(), 4}, self);
          },
          docs::kFeaturesKeypoints)
      .def_property_readonly(
          "descriptors",
          [](const py::object& self) {
            const auto& features = self.cast<const StoredFeatures&>();
            return ViewOf(features.descriptors(), {features.size(), features.descriptor_dim()},
                          self);
          },
          "float32 of shape (N, D), a view that cannot be written to.")
      .def_property_readonly("type", &StoredFeatures::type,
                             "The extractor, or the codec of projected descriptors.")
      .def_property_readonly("size", &SizeOrNone,
                             "(width, height) of the picture, pixels, or None.")
      .def("__len__", &StoredFeatures::size);
  module->def("extract", &Extract, arg("image"), arg("camera") = py::none(), py::kw_only(),
              arg("type") = "sift", arg("options") = py::none(), docs::kExtract);
}

}  // namespace cairn::python
