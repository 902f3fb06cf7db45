#include "python/fusion.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/geodesy.h"
#include "fusion/client/fusion_client.h"
#include "python/arguments.h"
#include "python/arrays.h"
#include "python/camera.h"
#include "python/docs.h"
#include "python/fusion_options.h"
#include "python/process_guard.h"
#include "python/result.h"

namespace cairn::python {
namespace {

using fusion::TrackedFeature;

// An inlier within this distance of a tracked feature is the same feature: less than the step by
// which two detectors disagree about a corner, and far less than two features are apart.
constexpr double kSameFeaturePx = 0.5;

constexpr std::array kImuStatus = {"accepted", "bad_input", "out_of_order", "restarted"};
constexpr std::array kFrameStatus = {"accepted", "bad_input", "out_of_order", "queue_full"};
constexpr std::array kSubmitStatus = {"queued", "queue_full"};
constexpr std::array kPredictStatus = {"ok", "no_state", "too_far_ahead", "too_far_behind"};
constexpr std::array kModes = {"initializing", "tracking", "aligning",
                               "localized",    "coasting", "lost"};
constexpr std::array kOutcomes = {"applied",         "awaits_alignment", "not_localized",
                                  "unknown_query",   "clone_gone",       "bad_input",
                                  "too_few_matches", "gravity_mismatch", "disagrees"};

template <size_t N, typename E>
const char* NameOf(const std::array<const char*, N>& names, E value) {
  return names.at(static_cast<size_t>(value));
}

py::array_t<uint64_t> TrackIds(const std::vector<TrackedFeature>& features) {
  py::array_t<uint64_t> ids(static_cast<py::ssize_t>(features.size()));
  for (size_t i = 0; i < features.size(); ++i) {
    ids.mutable_data()[i] = features[i].track_id;
  }
  return ids;
}

py::array_t<double> TrackPixels(const std::vector<TrackedFeature>& features) {
  Eigen::MatrixXd pixels(features.size(), 2);
  for (size_t i = 0; i < features.size(); ++i) {
    pixels.row(static_cast<Eigen::Index>(i)) = features[i].pixel.transpose();
  }
  return ArrayOf(pixels);
}

// The tracked feature at a pixel, if there is one.
std::optional<uint64_t> TrackAt(const fusion::Query& query, const Eigen::Vector2d& pixel) {
  for (const TrackedFeature& feature : query.features) {
    if ((feature.pixel - pixel).norm() < kSameFeaturePx) {
      return feature.track_id;
    }
  }
  return std::nullopt;
}

fusion::Answer AnswerOf(const fusion::Query& query, const LocalizeResult& result,
                        const Rigid3d& global_from_ecef) {
  fusion::Answer answer;
  answer.query_id = query.query_id;
  answer.localized = result.localized;
  if (!result.localized) {
    return answer;
  }
  answer.global_from_cam = global_from_ecef * result.cam_from_ecef.Inverse();
  const Rigid3d global_from_anchor = global_from_ecef * EcefFromEnu(result.anchor);
  for (const LocalizeMatch& match : result.matches) {
    if (match.camera_idx > 0) {
      continue;  // The filter knows one camera.
    }
    answer.matches.push_back({.pixel = match.pixel,
                              .track_id = TrackAt(query, match.pixel),
                              .x_in_global = global_from_anchor * match.x_in_anchor,
                              .sigma_m = match.sigma_m,
                              .landmark_id = Value(match.landmark_id),
                              .tile_id = result.tiles.at(match.tile_idx).value()});
  }
  return answer;
}

class PythonFusion {
 public:
  PythonFusion(const py::object& camera, const py::object& cam_from_imu, const py::object& origin,
               const py::object& options)
      : global_from_ecef_(EcefFromEnu(PositionOf("origin", origin)).Inverse()),
        client_(Create(camera, cam_from_imu, options)) {}

  const char* AddImu(const py::object& timestamps_ns, const py::object& gyro,
                     const py::object& accel) {
    const auto times = ColumnOf<int64_t>("timestamps_ns", timestamps_ns);
    const auto num = static_cast<py::ssize_t>(times.size());
    const auto rates = RowsOf("gyro_rad_s", gyro, 3, num);
    const auto forces = RowsOf("accel_m_s2", accel, 3, num);
    std::vector<fusion::ImuSample> samples(times.size());
    for (size_t i = 0; i < times.size(); ++i) {
      samples[i] = {times[i], Eigen::Map<const Eigen::Vector3d>(&rates[3 * i]),
                    Eigen::Map<const Eigen::Vector3d>(&forces[3 * i])};
    }
    const Turn turn(this);
    const py::gil_scoped_release release;
    return NameOf(kImuStatus, client_.get()->AddImu(samples));
  }

  const char* AddFrame(const py::object& timestamp_ns, const py::object& track_ids,
                       const py::object& pixels) {
    const int64_t time_ns = IntegerOf("timestamp_ns", timestamp_ns, INT64_MIN, INT64_MAX);
    const auto ids = ColumnOf<uint64_t>("track_ids", track_ids);
    const auto places = RowsOf("pixels", pixels, 2, static_cast<py::ssize_t>(ids.size()));
    std::vector<TrackedFeature> features(ids.size());
    for (size_t i = 0; i < ids.size(); ++i) {
      features[i] = {ids[i], {places[2 * i], places[2 * i + 1]}};
    }
    const Turn turn(this);
    const py::gil_scoped_release release;
    return NameOf(kFrameStatus, client_.get()->AddFrame({time_ns, features}));
  }

  std::optional<fusion::Query> PollQuery() {
    const Turn turn(this);
    return client_.get()->PollQuery();
  }

  const char* Submit(const fusion::Query& query, const PythonResult& result) {
    Require();
    return NameOf(kSubmitStatus,
                  client_.get()->Submit(AnswerOf(query, result.result, global_from_ecef_)));
  }

  py::list TakeReports() {
    const Turn turn(this);
    const py::object report_type = py::module_::import("cairn._support").attr("AnswerReport");
    py::list reports;
    for (const fusion::AnswerReport& report : client_.get()->TakeReports()) {
      reports.append(
          report_type(report.query_id, NameOf(kOutcomes, report.outcome), report.num_matches));
    }
    return reports;
  }

  fusion::Estimate Latest() const {
    Require();
    return client_.get()->Latest();
  }

  py::tuple Predict(const py::object& timestamp_ns) const {
    Require();
    const fusion::Prediction prediction =
        client_.get()->Predict(IntegerOf("timestamp_ns", timestamp_ns, INT64_MIN, INT64_MAX));
    const bool is_ok = prediction.status == fusion::PredictStatus::kOk;
    return py::make_tuple(NameOf(kPredictStatus, prediction.status),
                          is_ok ? py::cast(prediction.estimate) : py::none());
  }

 private:
  // One call at a time: the order of samples and frames is their meaning.
  class Turn {
   public:
    explicit Turn(PythonFusion* client) : client_(client) {
      client->Require();
      if (client->is_busy_.exchange(true)) {
        throw Error(ErrorCode::kConflict,
                    "client: another thread is in a call of this cairn.FusionClient; feed it from "
                    "one thread");
      }
    }
    ~Turn() { client_->is_busy_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    PythonFusion* client_;
  };

  void Require() const { client_.guard().Require("client: this cairn.FusionClient"); }

  static std::shared_ptr<fusion::FusionClient> Create(const py::object& camera,
                                                      const py::object& cam_from_imu,
                                                      const py::object& options_argument) {
    fusion::FusionOptions options;
    const std::optional<StatedCamera> stated = CameraOf("camera", camera);
    if (!stated) {
      RefuseArgument("camera", "must be a cairn.Camera");
    }
    options.camera = stated->camera;
    options.rig.cam_from_imu = PoseOf("cam_from_imu", cam_from_imu);
    SetFusionOptions(options_argument, &options);
    auto [client, error] = fusion::FusionClient::Create(options);
    if (client == nullptr) {
      RefuseArgument("options", error);
    }
    return std::move(client);
  }

  Rigid3d global_from_ecef_;
  AtHome<fusion::FusionClient> client_;
  std::atomic<bool> is_busy_ = false;
};

void BindFusionQuery(py::module_* module) {
  using fusion::Query;
  py::class_<Query>(*module, "FusionQuery", docs::kFusionQuery)
      .def_readonly("query_id", &Query::query_id, "Number of the query.")
      .def_readonly("timestamp_ns", &Query::timestamp_ns, "Time of the frame.")
      .def_property_readonly(
          "track_ids", [](const Query& query) { return TrackIds(query.features); },
          "uint64 (N,): ids of the frame's tracks.")
      .def_property_readonly(
          "pixels", [](const Query& query) { return TrackPixels(query.features); },
          "float64 (N, 2): where the frame shows them.")
      .def_property_readonly(
          "gravity", [](const Query& query) { return VectorArrayOf(query.down_in_cam); },
          "float64 (3,): unit vector down in the camera frame; the gravity of a query.")
      .def_property_readonly(
          "global_from_cam",
          [](const Query& query) -> py::object {
            return query.prior ? py::object(PoseArray(query.prior->global_from_cam)) : py::none();
          },
          "4 x 4: the pose that the filter expects, or None before the alignment.");
}

// A property that is None as long as the place in global is unknown.
template <typename Get>
auto IfGlobal(const Get& get) {
  return [get](const fusion::Estimate& estimate) -> py::object {
    return estimate.has_global ? py::object(get(estimate)) : py::none();
  };
}

void BindEstimate(py::module_* module) {
  using fusion::Estimate;
  py::class_<Estimate>(*module, "FusionEstimate", docs::kFusionEstimate)
      .def_property_readonly(
          "mode", [](const Estimate& estimate) { return NameOf(kModes, estimate.mode); },
          docs::kFusionMode)
      .def_readonly("timestamp_ns", &Estimate::timestamp_ns, "In the clock of the IMU.")
      .def_readonly("epoch", &Estimate::epoch,
                    "Counts restarts; poses of different epochs are not comparable.")
      .def_property_readonly(
          "local_from_imu",
          [](const Estimate& estimate) { return PoseArray(estimate.imu.local_from_imu); },
          "4 x 4: pose in the level frame of the device, free of jumps, meters.")
      .def_property_readonly(
          "velocity_in_local",
          [](const Estimate& estimate) { return VectorArrayOf(estimate.imu.velocity_in_local); },
          "float64 (3,): m/s.")
      .def_property_readonly(
          "covariance", [](const Estimate& estimate) { return ArrayOf(estimate.covariance); },
          "15 x 15: of (rotation, position, velocity, gyro bias, accel bias).")
      .def_property_readonly("global_from_imu", IfGlobal([](const Estimate& estimate) {
                               return PoseArray(estimate.global_from_imu);
                             }),
                             "4 x 4: best pose in enu at the origin, or None before the alignment.")
      .def_property_readonly("global_covariance", IfGlobal([](const Estimate& estimate) {
                               return ArrayOf(estimate.global_from_imu_covariance);
                             }),
                             "6 x 6: of (rotation, translation) of global_from_imu, or None.")
      .def_property_readonly("steady_global_from_imu", IfGlobal([](const Estimate& estimate) {
                               return PoseArray(estimate.steady_global_from_imu);
                             }),
                             "4 x 4: the same pose without jumps, for displays, or None.");
}

}  // namespace

void BindFusion(py::module_* module) {
  using py::arg;
  BindFusionQuery(module);
  BindEstimate(module);
  py::class_<PythonFusion>(*module, "FusionClient", docs::kFusionClient)
      .def(py::init<const py::object&, const py::object&, const py::object&, const py::object&>(),
           arg("camera"), arg("cam_from_imu"), arg("origin"), arg("options") = py::none())
      .def("add_imu", &PythonFusion::AddImu, arg("timestamps_ns"), arg("gyro_rad_s"),
           arg("accel_m_s2"), docs::kAddImu)
      .def("add_frame", &PythonFusion::AddFrame, arg("timestamp_ns"), arg("track_ids"),
           arg("pixels"), docs::kAddFrame)
      .def(
          "poll_query",
          [](PythonFusion& self) -> py::object {
            auto query = self.PollQuery();
            return query ? py::cast(std::move(*query)) : py::none();
          },
          docs::kPollQuery)
      .def("submit", &PythonFusion::Submit, arg("query"), arg("result"), docs::kSubmit)
      .def("take_reports", &PythonFusion::TakeReports, docs::kTakeReports)
      .def("latest", &PythonFusion::Latest, "The estimate at the newest inertial sample.")
      .def("predict", &PythonFusion::Predict, arg("timestamp_ns"), docs::kPredict);
}

}  // namespace cairn::python
