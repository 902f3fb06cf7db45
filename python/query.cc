#include "python/query.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/images/photo_camera.h"
#include "core/seconds_since.h"
#include "http/json/request_photos.h"
#include "python/arguments.h"
#include "python/docs.h"

namespace cairn::python {
namespace {

using Clock = std::chrono::steady_clock;

// Adds to `owners` what the result refers to: the image, which the item may let go of.
RigInput RigInputOf(const std::string& argument, py::handle value,
                    std::vector<py::object>* owners) {
  if (!py::isinstance<py::sequence>(value) || py::isinstance<py::str>(value) ||
      py::len(value) != 3) {
    RefuseArgument(argument, "must be (image, camera, cam_from_first)");
  }
  const auto parts = py::reinterpret_borrow<py::sequence>(value);
  const std::optional<StatedCamera> camera = CameraOf(argument + "[1]", parts[1]);
  if (!camera || camera->focal) {
    RefuseArgument(argument + "[1]", "a rig needs cameras without a focal_sigma");
  }
  const py::object image = parts[0];
  owners->push_back(image);
  return {CameraInputOf(argument + "[0]", image), camera->camera,
          PoseOf(argument + "[2]", parts[2])};
}

// The other cameras of a rig.
void AddRig(const py::object& rig, PythonQuery* query) {
  if (!py::isinstance<py::iterable>(rig) || py::isinstance<py::str>(rig)) {
    RefuseArgument("rig", "must be a sequence of (image, camera, cam_from_first)");
  }
  for (const py::handle item : rig) {
    query->stated.rig.push_back(
        RigInputOf(fmt::format("rig[{}]", query->stated.rig.size()), item, &query->owners));
  }
}

// The camera of the query's own picture.
StatedCamera OwnCamera(const StatedQuery& stated, const ExifInfo* exif, int width_px,
                       int height_px) {
  if (!stated.camera) {
    PhotoCamera of_photo = CameraOfPhoto(exif == nullptr ? ExifInfo() : *exif, width_px, height_px);
    return {std::move(of_photo.camera), of_photo.focal};
  }
  const Camera& camera = stated.camera->camera;
  if (camera.width_px() != width_px || camera.height_px() != height_px) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("camera: its images have {} x {} pixels, but this one has {} x {}",
                            camera.width_px(), camera.height_px(), width_px, height_px));
  }
  return *stated.camera;
}

// The size of the picture that features lie in: as they say, or else that of the camera.
std::array<int, 2> SizeOfFeatures(const StoredFeatures& features, const Camera* camera) {
  if (features.image_size_px()) {
    return *features.image_size_px();
  }
  if (camera == nullptr) {
    throw Error(ErrorCode::kInvalidArgument,
                "camera: features without a size need one; give camera, or "
                "cairn.Features(..., size=(width, height))");
  }
  return {camera->width_px(), camera->height_px()};
}

void RequireType(const StoredFeatures& features, const std::string& descriptor_type) {
  if (!features.is_projected() && !descriptor_type.empty() && features.type() != descriptor_type) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("image: features of type '{}', but the map has '{}'", features.type(),
                            descriptor_type));
  }
}

void Lend(const std::shared_ptr<StoredFeatures>& features, const std::string& descriptor_type,
          FeatureSet* to, LentQuery* filled) {
  RequireType(*features, descriptor_type);
  if (features->is_projected()) {
    filled->query.codec = features->type();
  }
  filled->loans.push_back(std::make_unique<FeatureLoan>(features, to));
}

Picture Read(const CameraInput& input, const Camera* camera, LentQuery* filled) {
  const auto start = Clock::now();
  Picture picture = ReadPicture(input, camera);
  filled->decode_seconds += SecondsSince(start);
  return picture;
}

FeatureSet Extract(const Picture& picture, const FeatureExtractor& extractor, LentQuery* filled) {
  const auto start = Clock::now();
  FeatureSet features = extractor.Extract(picture.image);
  filled->extract_seconds += SecondsSince(start);
  return features;
}

void FillRig(const StatedQuery& stated, const FeatureExtractor& extractor,
             const std::string& descriptor_type, LentQuery* filled) {
  std::vector<RigCamera>& others = filled->query.other_cameras;
  for (size_t i = 0; i < stated.rig.size(); ++i) {
    const RigInput& seen = stated.rig[i];
    if (seen.input.features) {
      Lend(seen.input.features, descriptor_type, &others[i].features, filled);
      continue;
    }
    const Picture picture = Read(seen.input, &seen.camera, filled);
    if (picture.image.picture_width_px() != seen.camera.width_px() ||
        picture.image.picture_height_px() != seen.camera.height_px()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("rig[{}]: the camera's images have another size than this one", i));
    }
    others[i].features = Extract(picture, extractor, filled);
  }
}

}  // namespace

PythonQuery MakeQuery(const py::object& image, const py::object& camera, const py::object& prior,
                      const py::object& accuracy_m, const py::object& gravity,
                      const py::object& rig, const py::object& timeout_ms,
                      const py::object& exif_prior) {
  PythonQuery query;
  StatedQuery& stated = query.stated;
  stated.input = CameraInputOf("image", image);
  query.owners.push_back(image);
  stated.camera = CameraOf("camera", camera);
  stated.exif_prior = FlagOf("exif_prior", exif_prior);
  const double radius_m = NumberOf("accuracy_m", accuracy_m, 1e-3, PositionPrior::kMaxAccuracyM);
  if (!prior.is_none()) {
    stated.prior.emplace();
    stated.prior->position = PositionOf("prior", prior);
    stated.prior->accuracy_m = radius_m;
  }
  if (!gravity.is_none()) {
    stated.down_in_cam = DirectionOf("gravity", gravity);
  }
  if (!rig.is_none()) {
    AddRig(rig, &query);
  }
  if (!timeout_ms.is_none()) {
    stated.timeout_ms = static_cast<int>(IntegerOf("timeout_ms", timeout_ms, 1, 3'600'000));
  }
  return query;
}

PythonQuery QueryOfCall(const py::object& image, const py::object& camera, const py::object& prior,
                        const py::object& accuracy_m, const py::object& gravity,
                        const py::object& rig, const py::object& timeout_ms,
                        const py::object& exif_prior) {
  if (!py::isinstance<PythonQuery>(image)) {
    return MakeQuery(image, camera, prior, accuracy_m, gravity, rig, timeout_ms, exif_prior);
  }
  for (const auto& [name, value] :
       {std::pair("camera", camera), std::pair("prior", prior), std::pair("gravity", gravity),
        std::pair("rig", rig), std::pair("timeout_ms", timeout_ms)}) {
    if (!value.is_none()) {
      RefuseArgument(name, "is part of the cairn.Query already");
    }
  }
  return image.cast<PythonQuery>();
}

PythonQuery QueryOf(const std::string& argument, const py::object& value) {
  if (py::isinstance<PythonQuery>(value)) {
    return value.cast<PythonQuery>();
  }
  PythonQuery query;
  query.stated.input = CameraInputOf(argument, value);
  query.owners.push_back(value);
  return query;
}

LocalizeQuery QueryWithoutFeatures(const StatedQuery& stated, const ExifInfo* exif, int width_px,
                                   int height_px) {
  LocalizeQuery query;
  StatedCamera own = OwnCamera(stated, exif, width_px, height_px);
  query.camera = std::move(own.camera);
  query.focal = own.focal;
  if (!stated.rig.empty() && query.focal) {
    if (query.focal->with_distortion) {
      throw Error(ErrorCode::kInvalidArgument,
                  "camera: a rig needs the focal length, which the photo does not state");
    }
    query.focal.reset();
  }
  for (const RigInput& seen : stated.rig) {
    query.other_cameras.push_back({seen.camera, seen.cam_from_first, {}});
  }
  query.prior = stated.prior;
  if (!query.prior && stated.exif_prior && exif != nullptr) {
    query.prior = PriorOfPhoto(*exif);
  }
  query.down_in_cam = stated.down_in_cam;
  return query;
}

void FillQuery(const StatedQuery& stated, const FeatureExtractor& extractor,
               const std::string& descriptor_type, LentQuery* filled) {
  const auto start = Clock::now();
  const Camera* camera = stated.camera ? &stated.camera->camera : nullptr;
  if (stated.input.features) {
    const auto [width_px, height_px] = SizeOfFeatures(*stated.input.features, camera);
    filled->query = QueryWithoutFeatures(stated, nullptr, width_px, height_px);
    Lend(stated.input.features, descriptor_type, &filled->query.features, filled);
  } else {
    const Picture picture = Read(stated.input, camera, filled);
    filled->query = QueryWithoutFeatures(stated, &picture.exif, picture.image.picture_width_px(),
                                         picture.image.picture_height_px());
    filled->query.features = Extract(picture, extractor, filled);
  }
  FillRig(stated, extractor, descriptor_type, filled);
  if (stated.timeout_ms) {
    filled->query.deadline = start + std::chrono::milliseconds(*stated.timeout_ms);
  }
}

void BindQuery(py::module_* module) {
  using py::arg;
  py::class_<PythonQuery>(*module, "Query", docs::kQuery)
      .def(py::init(&MakeQuery), arg("image"), arg("camera") = py::none(), py::kw_only(),
           arg("prior") = py::none(), arg("accuracy_m") = 15.0, arg("gravity") = py::none(),
           arg("rig") = py::none(), arg("timeout_ms") = py::none(), arg("exif_prior") = true);
}

}  // namespace cairn::python
