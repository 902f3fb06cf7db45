// Tracks a phone without and with a map server, and plots both trajectories.
//
// The program renders a street, makes a map of it, serves the map over HTTP on loopback, and
// simulates a walk down the street with a phone. Rendered images go through the KLT front end.
// Inertial samples go to the filter. Once a second a query goes to the server; its answer reaches
// the filter 200 ms later.
//
//   track_and_localize --output out [--seconds 25] [--latency-ms 200]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/demo/street/street_scene.h"
#include "core/error.h"
#include "core/features/klt/klt_tracker.h"
#include "core/features/sift/sift_extractor.h"
#include "fusion/client/fusion_client.h"
#include "fusion/transport/map_transport.h"
#include "http/server.h"
#include "phone_walk.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/map/map_store.h"
#include "street_map.h"
#include "write_results.h"

namespace cairn {
namespace {

struct Arguments {
  std::string output_dir;
  double duration_s = 25.0;
  double latency_s = 0.2;
  uint64_t seed = 1;
};

constexpr double kFrameRateHz = 10.0;
constexpr double kImuRateHz = 200.0;
constexpr int kMaxQueryFeatures = 500;
// A keypoint within this distance of a tracked feature is the same feature.
constexpr double kSameFeaturePx = 0.5;

// Passes answers from the transport's worker thread to the filter's thread.
class Mailbox {
 public:
  void Put(fusion::Answer answer) {
    const std::lock_guard lock(mutex_);
    answers_.push_back(std::move(answer));
    changed_.notify_all();
  }
  fusion::Answer Take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !answers_.empty(); });
    fusion::Answer answer = std::move(answers_.front());
    answers_.pop_front();
    return answer;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<fusion::Answer> answers_;
};

std::unique_ptr<fusion::FusionClient> MakeClient(const Camera& camera) {
  fusion::FusionOptions options;
  options.camera = camera;
  options.rig = PhoneWalk::PhoneRig();
  auto [client, error] = fusion::FusionClient::Create(options);
  if (!client) {
    throw Error(ErrorCode::kInvalidArgument, error);
  }
  return std::move(client);
}

// The phone: two filters on the same sensors. Only one of them queries the map.
class Phone {
 public:
  Phone(const StreetScene& scene, const std::string& map_path, const std::string& server_url,
        const Arguments& arguments)
      : scene_(scene),
        arguments_(arguments),
        walk_(scene.options()),
        codec_(MapStore::Open(map_path, OpenMode::kReadOnly).Snapshot().CurrentCodebook()),
        tracker_(fusion::KltOptions()),
        alone_(MakeClient(scene.camera())),
        fused_(MakeClient(scene.camera())),
        transport_(TransportOptions(server_url),
                   [this](fusion::Answer answer) { mailbox_.Put(std::move(answer)); }) {}

  std::vector<TrackPoint> Walk() {
    const std::vector<fusion::ImuSample> imu =
        walk_.Measure(arguments_.duration_s, kImuRateHz, fusion::ImuNoise(), arguments_.seed);
    std::vector<TrackPoint> points;
    size_t next_imu = 0;
    const int num_frames = static_cast<int>(arguments_.duration_s * kFrameRateHz);
    for (int i = 0; i < num_frames; ++i) {
      const double time_s = i / kFrameRateHz;
      DeliverAnswers(time_s);
      while (next_imu < imu.size() && imu[next_imu].timestamp_ns <= PhoneTimeNs(time_s)) {
        alone_->AddImu({&imu[next_imu], 1});
        fused_->AddImu({&imu[next_imu], 1});
        ++next_imu;
      }
      const GrayImage image = scene_.Render(walk_.CamFromEnu(time_s), static_cast<uint64_t>(i));
      const auto features =
          tracker_.Track({image.pixels.data(), image.width_px, image.height_px, image.width_px});
      alone_->AddFrame({PhoneTimeNs(time_s), features});
      fused_->AddFrame({PhoneTimeNs(time_s), features});
      AskMap(time_s, image, features);
      AddPoint(time_s, &points);
    }
    return points;
  }

  fusion::MapTransportCounters counters() const { return transport_.counters(); }

 private:
  struct Delivery {
    double time_s;
    fusion::Answer answer;
  };

  fusion::MapTransportOptions TransportOptions(const std::string& server_url) const {
    fusion::MapTransportOptions options;
    options.url = server_url;
    options.global_origin = scene_.options().origin;
    options.timeout_ms = 30'000;
    // The simulated clock runs faster or slower than the transport's clock.
    options.min_interval_s = 0.0;
    return options;
  }

  void DeliverAnswers(double time_s) {
    while (!deliveries_.empty() && deliveries_.front().time_s <= time_s) {
      fused_->Submit(std::move(deliveries_.front().answer));
      deliveries_.pop_front();
    }
  }

  // Waits for the server, because the walk is simulated. The filter receives the answer later.
  void AskMap(double time_s, const GrayImage& image,
              std::span<const fusion::TrackedFeature> features) {
    auto query = fused_->PollQuery();
    if (!query) {
      return;
    }
    fusion::MapQuery question;
    question.request = std::move(*query);
    question.camera = scene_.camera();
    const FeatureSet sift = ExtractSift(image, {.max_features = kMaxQueryFeatures});
    question.features = {sift.keypoints, codec_.ProjectFeatures(sift), DescriptorSpace::kProjected};
    question.codec = codec_.codebook().CodecName();
    question.track_of_keypoint = TracksOf(sift, features);
    question.rough_position = {
        GeodeticFromEcef(EcefFromEnu(scene_.options().origin) *
                         (walk_.EnuFromImu(time_s).translation + Eigen::Vector3d(6.0, -5.0, 2.0))),
        10.0};
    if (transport_.Send(std::move(question)) == fusion::SendStatus::kQueued) {
      deliveries_.push_back({time_s + arguments_.latency_s, mailbox_.Take()});
    }
  }

  static std::vector<std::optional<uint64_t>> TracksOf(
      const FeatureSet& sift, std::span<const fusion::TrackedFeature> features) {
    std::vector<std::optional<uint64_t>> tracks(sift.keypoints.size());
    for (size_t i = 0; i < sift.keypoints.size(); ++i) {
      const Eigen::Vector2d pixel(sift.keypoints[i].x_px, sift.keypoints[i].y_px);
      for (const fusion::TrackedFeature& feature : features) {
        if ((feature.pixel - pixel).norm() < kSameFeaturePx) {
          tracks[i] = feature.track_id;
        }
      }
    }
    return tracks;
  }

  void AddPoint(double time_s, std::vector<TrackPoint>* points) {
    const fusion::Estimate alone = alone_->Latest();
    const fusion::Estimate fused = fused_->Latest();
    if (alone.mode == fusion::Mode::kInitializing) {
      return;
    }
    const Rigid3d truth = walk_.EnuFromImu(1e-9 * static_cast<double>(alone.timestamp_ns));
    if (!enu_from_alone_) {
      enu_from_alone_ = truth * alone.imu.local_from_imu.Inverse();
    }
    points->push_back({time_s, truth.translation,
                       *enu_from_alone_ * alone.imu.local_from_imu.translation,
                       fused.global_from_imu.translation, fused.steady_global_from_imu.translation,
                       fused.has_global});
  }

  const StreetScene& scene_;
  const Arguments& arguments_;
  PhoneWalk walk_;
  DescriptorCodec codec_;
  fusion::KltTracker tracker_;
  std::unique_ptr<fusion::FusionClient> alone_;
  std::unique_ptr<fusion::FusionClient> fused_;
  Mailbox mailbox_;
  fusion::MapTransport transport_;
  std::deque<Delivery> deliveries_;
  std::optional<Rigid3d> enu_from_alone_;  // From the true pose at the start.
};

void Run(const Arguments& arguments) {
  const std::filesystem::path dir = arguments.output_dir;
  std::filesystem::create_directories(dir);
  StreetOptions street;
  street.length_m = 60.0;
  street.seed = arguments.seed;
  const StreetScene scene(street);
  const std::string map_path = (dir / "street.gpkg").string();
  std::puts("making the map");
  MakeStreetMap(scene, map_path);
  ServerOptions server_options;
  server_options.map_path = map_path;
  server_options.port = 0;
  server_options.default_timeout_ms = 30'000;
  Server server(server_options);
  server.Start();
  std::puts("walking");
  Phone phone(scene, map_path, fmt::format("http://127.0.0.1:{}", server.port()), arguments);
  const std::vector<TrackPoint> points = phone.Walk();
  const bool has_plot = WriteResults(dir, points);
  const TrackErrors errors = ErrorsOf(points);
  const fusion::MapTransportCounters counters = phone.counters();
  fmt::print("{} queries, {} localized, {:.1f} kB each\n", counters.num_sent,
             counters.num_localized,
             1e-3 * static_cast<double>(counters.num_bytes_sent) /
                 static_cast<double>(std::max<int64_t>(1, counters.num_sent)));
  fmt::print(
      "{} frames fused; rmse alone {:.3f} m, fused {:.3f} m; at the end {:.3f} m, {:.3f} m\n",
      errors.num_fused, errors.local_rmse_m, errors.fused_rmse_m, errors.local_final_m,
      errors.fused_final_m);
  fmt::print(
      "from frame to frame the error of the estimate changes by {:.1f} mm, that of what is "
      "shown by {:.1f} mm (rmse {:.3f} m)\n",
      1e3 * errors.fused_change_m, 1e3 * errors.shown_change_m, errors.shown_rmse_m);
  fmt::print("wrote {}\n", (dir / (has_plot ? "trajectory.png" : "trajectory.csv")).string());
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  CLI::App app("Tracks a simulated phone with and without a map server");
  cairn::Arguments arguments;
  double latency_ms = 200.0;
  app.add_option("--output", arguments.output_dir, "Folder for map and results")->required();
  app.add_option("--seconds", arguments.duration_s, "Length of the walk")
      ->check(CLI::Range(5.0, 35.0));
  app.add_option("--latency-ms", latency_ms, "Added to each answer")
      ->check(CLI::Range(0.0, 5000.0));
  app.add_option("--seed", arguments.seed, "Of street and noise");
  CLI11_PARSE(app, argc, argv);
  arguments.latency_s = 1e-3 * latency_ms;
  try {
    cairn::Run(arguments);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "track_and_localize: %s\n", e.what());
    return 1;
  }
  return 0;
}
