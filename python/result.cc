#include "python/result.h"

#include <fmt/format.h>

#include <string>

#include "core/geodesy.h"
#include "core/wire/inner_frame.h"
#include "python/arrays.h"
#include "python/camera.h"
#include "python/docs.h"

namespace cairn::python {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

Rigid3d EnuFromEcef(const LocalizeResult& result) { return EcefFromEnu(result.position).Inverse(); }

// Of (rotation, translation) as in LocalizeResult, but in enu at the camera.
Matrix6d CovarianceInEnu(const LocalizeResult& result) {
  const Eigen::Matrix3d enu_from_anchor =
      (EnuFromEcef(result).rotation * EcefFromEnu(result.anchor).rotation).toRotationMatrix();
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = enu_from_anchor;
  rotation.bottomRightCorner<3, 3>() = enu_from_anchor;
  return rotation * result.covariance * rotation.transpose();
}

// The inliers as arrays with a row for each.
struct Inliers {
  py::array_t<double> pixel, ecef, error_px, sigma_m;
  py::array_t<uint64_t> landmark_id;
  py::array_t<int32_t> keypoint, camera;

  explicit Inliers(const LocalizeResult& result)
      : pixel({static_cast<py::ssize_t>(result.matches.size()), py::ssize_t{2}}),
        ecef({static_cast<py::ssize_t>(result.matches.size()), py::ssize_t{3}}),
        error_px(static_cast<py::ssize_t>(result.matches.size())),
        sigma_m(static_cast<py::ssize_t>(result.matches.size())),
        landmark_id(static_cast<py::ssize_t>(result.matches.size())),
        keypoint(static_cast<py::ssize_t>(result.matches.size())),
        camera(static_cast<py::ssize_t>(result.matches.size())) {
    const Rigid3d ecef_from_anchor = EcefFromEnu(result.anchor);
    for (size_t i = 0; i < result.matches.size(); ++i) {
      const LocalizeMatch& match = result.matches[i];
      Eigen::Map<Eigen::Vector2d>(pixel.mutable_data() + 2 * i) = match.pixel;
      Eigen::Map<Eigen::Vector3d>(ecef.mutable_data() + 3 * i) =
          ecef_from_anchor * match.x_in_anchor;
      error_px.mutable_data()[i] = match.traits.error_px;
      sigma_m.mutable_data()[i] = match.sigma_m;
      landmark_id.mutable_data()[i] = Value(match.landmark_id);
      keypoint.mutable_data()[i] = match.keypoint_idx;
      camera.mutable_data()[i] = match.camera_idx;
    }
  }
};

py::dict StagesOf(const PythonResult& answer) {
  py::dict stages;
  stages["decode"] = answer.decode_seconds;
  stages["extract"] = answer.extract_seconds;
  for (int stage = 0; stage < kNumStages; ++stage) {
    stages[StageName(static_cast<Stage>(stage))] = answer.result.times.seconds[stage];
  }
  stages["total"] = answer.decode_seconds + answer.extract_seconds + answer.localize_seconds;
  return stages;
}

py::tuple TilesOf(const LocalizeResult& result) {
  py::list names;
  for (const TileId& tile : result.tiles) {
    names.append(tile.ToString());
  }
  return py::tuple(names);
}

std::string RepresentResult(const PythonResult& answer) {
  const LocalizeResult& result = answer.result;
  if (!result.localized) {
    return fmt::format("<cairn.Result: {}: {}>", NotLocalizedReasonName(result.reason),
                       result.reason_text);
  }
  return fmt::format("<cairn.Result: {:.7f}, {:.7f}, {:.2f} m; {} inliers; confidence {:.3f}>",
                     result.position.lat_deg(), result.position.lon_deg(), result.position.h_m,
                     result.matches.size(), result.confidence);
}

// A property that is None without a pose.
template <typename Get>
auto IfLocalized(const Get& get) {
  return [get](const PythonResult& answer) -> py::object {
    return answer.result.localized ? py::object(get(answer.result)) : py::none();
  };
}

void BindGeoPose(py::module_* module) {
  py::class_<GeoPose>(*module, "GeoPose", docs::kGeoPose)
      .def_property_readonly(
          "lat_deg", [](const GeoPose& pose) { return pose.position.lat_deg(); },
          "WGS84 latitude, degrees.")
      .def_property_readonly(
          "lon_deg", [](const GeoPose& pose) { return pose.position.lon_deg(); },
          "WGS84 longitude, degrees.")
      .def_property_readonly(
          "h_m", [](const GeoPose& pose) { return pose.position.h_m; },
          "Height above the ellipsoid, meters.")
      .def_property_readonly(
          "quaternion",
          [](const GeoPose& pose) {
            const Eigen::Quaterniond& q = pose.enu_from_inner;
            return py::make_tuple(q.x(), q.y(), q.z(), q.w());
          },
          "(x, y, z, w): from forward-left-up of the camera to east-north-up.")
      .def(
          "to_dict",
          [](const GeoPose& pose) {
            const Eigen::Quaterniond& q = pose.enu_from_inner;
            using py::operator""_a;
            return py::dict("position"_a = py::dict("lat"_a = pose.position.lat_deg(),
                                                    "lon"_a = pose.position.lon_deg(),
                                                    "h"_a = pose.position.h_m),
                            "quaternion"_a = py::dict("x"_a = q.x(), "y"_a = q.y(), "z"_a = q.z(),
                                                      "w"_a = q.w()));
          },
          "The OGC GeoPose (Basic-Quaternion) as a dict for json.dumps.");
}

void BindInliers(py::module_* module) {
  py::class_<Inliers>(*module, "Inliers", docs::kInliers)
      .def_readonly("pixel", &Inliers::pixel, "float64 (N, 2): where the photo shows them.")
      .def_readonly("ecef", &Inliers::ecef, "float64 (N, 3): the landmarks in ECEF, meters.")
      .def_readonly("error_px", &Inliers::error_px, "float64 (N,): reprojection errors, pixels.")
      .def_readonly("sigma_m", &Inliers::sigma_m,
                    "float64 (N,): standard deviations of the landmarks' positions, meters.")
      .def_readonly("landmark_id", &Inliers::landmark_id, "uint64 (N,): ids of the landmarks.")
      .def_readonly("keypoint", &Inliers::keypoint,
                    "int32 (N,): rows of the features of their camera.")
      .def_readonly("camera", &Inliers::camera,
                    "int32 (N,): 0 is the query's own camera, i is rig[i - 1].")
      .def("__len__", [](const Inliers& inliers) { return inliers.error_px.size(); });
}

void BindPose(py::class_<PythonResult>* result) {
  result
      ->def_property_readonly(
          "geopose", IfLocalized([](const LocalizeResult& answer) {
            return py::cast(GeoPoseFromCamera(answer.cam_from_ecef, InnerFrame::kFlu));
          }),
          "The pose as a GeoPose, or None.")
      .def_property_readonly("ecef_from_cam", IfLocalized([](const LocalizeResult& answer) {
                               return PoseArray(answer.cam_from_ecef.Inverse());
                             }),
                             docs::kEcefFromCam)
      .def_property_readonly(
          "enu_from_cam", IfLocalized([](const LocalizeResult& answer) {
            return PoseArray(EnuFromEcef(answer) * answer.cam_from_ecef.Inverse());
          }),
          docs::kEnuFromCam)
      .def_property_readonly("covariance", IfLocalized([](const LocalizeResult& answer) {
                               return ArrayOf(CovarianceInEnu(answer));
                             }),
                             docs::kCovariance)
      .def_property_readonly("inliers", IfLocalized([](const LocalizeResult& answer) {
                               return py::cast(Inliers(answer));
                             }),
                             "The inliers of the pose as arrays, or None.")
      .def_property_readonly(
          "camera",
          [](const PythonResult& answer) -> py::object {
            const auto& camera = answer.result.camera;
            return camera ? py::cast(StatedCamera{camera->camera, {}}) : py::none();
          },
          docs::kEstimatedCamera)
      .def_property_readonly(
          "focal_sigma_px",
          [](const PythonResult& answer) -> py::object {
            const auto& camera = answer.result.camera;
            return camera ? py::cast(camera->focal_sigma_px) : py::none();
          },
          "Standard deviation of the estimated focal length, pixels, or None.");
}

template <typename T>
auto Field(T LocalizeResult::*field) {
  return [field](const PythonResult& answer) { return answer.result.*field; };
}

}  // namespace

void BindResult(py::module_* module) {
  BindGeoPose(module);
  BindInliers(module);
  py::class_<PythonResult> result(*module, "Result", docs::kResult);
  BindPose(&result);
  result
      .def_property_readonly("localized", Field(&LocalizeResult::localized),
                             "Whether there is a pose.")
      .def_property_readonly(
          "reason",
          [](const PythonResult& answer) -> py::object {
            return answer.result.localized ? py::object(py::none())
                                           : py::str(NotLocalizedReasonName(answer.result.reason));
          },
          docs::kReason)
      .def_property_readonly("reason_text", Field(&LocalizeResult::reason_text),
                             "Without a pose: why, and what to do. Else empty.")
      .def_property_readonly("confidence", Field(&LocalizeResult::confidence),
                             "Probability that the pose is within 3 m and 10 degrees.")
      .def_property_readonly("score", Field(&LocalizeResult::score),
                             "How far the evidence is from chance, as a logarithm.")
      .def_property_readonly("position_accuracy_m", Field(&LocalizeResult::position_accuracy_m),
                             "68 % radius of the position in the map, meters.")
      .def_property_readonly("rotation_accuracy_rad", Field(&LocalizeResult::rotation_accuracy_rad),
                             "68 % radius of the orientation in the map, radians.")
      .def_property_readonly("map_accuracy_m", Field(&LocalizeResult::map_accuracy_m),
                             "68 % radius of the map's own place on Earth, meters.")
      .def_property_readonly("prior_disagrees", Field(&LocalizeResult::prior_disagrees),
                             "Whether the position is farther from the prior than 99 % are.")
      .def_property_readonly(
          "map_version",
          [](const PythonResult& answer) { return Value(answer.result.map_version); },
          "Version of the map that answered.")
      .def_property_readonly(
          "tiles", [](const PythonResult& answer) { return TilesOf(answer.result); },
          "Names of the tiles that were searched.")
      .def_property_readonly("stages", &StagesOf, docs::kStages)
      .def("__repr__", &RepresentResult);
}

}  // namespace cairn::python
