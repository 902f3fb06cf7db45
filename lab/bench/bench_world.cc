#include "lab/bench/bench_world.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numeric>
#include <random>
#include <utility>

#include "core/angles.h"
#include "core/require.h"
#include "core/scene/reconstruction.h"
#include "engine/index/inverted_lists.h"
#include "ingest/codebook/train_codebook.h"
#include "lab/bench/bench_streets.h"
#include "lab/bench/lane_index.h"
#include "lab/descriptors/descriptor_model.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr double kLandmarkSigmaM = 0.05;
constexpr double kPixelNoisePx = 0.5;
constexpr double kOrientationNoiseRad = 0.05;
constexpr double kLogSizeNoise = 0.1;
constexpr int kTrainingLandmarks = 20'000;
constexpr int kTrainingObservations = 3;
constexpr int kLandmarksPerView = 800;  // Per keyframe.
constexpr size_t kEncodeBatch = 8192;
constexpr uint64_t kQueryObservation = 1'000;  // Larger than the numbers of the map's observations.

// Vehicles in one lane see a landmark from similar directions; the views differ by up to this much.
constexpr double kViewSpreadRad = 0.4;
constexpr double kLog2ScaleSpread = 1.0;

// Landmarks have no repetitions. Views are a low-discrepancy sequence over the observations.
DescriptorLook Look(uint64_t landmark, uint64_t observation) {
  const auto unit = [&](double step) {
    const double at = step * static_cast<double>(observation % 4096 + landmark % 4096);
    return at - std::floor(at);
  };
  return {.ornament = landmark,
          .landmark = landmark,
          .view_azimuth_rad = kViewSpreadRad * (unit(0.7548776662466927) - 0.5),
          .log2_scale = kLog2ScaleSpread * (unit(0.5698402909980532) - 0.5),
          .observation = observation};
}

class WorldBuilder {
 public:
  WorldBuilder(const BenchWorldOptions& options, const std::string& map_path)
      : options_(options),
        sift_({.seed = options.seed}),
        generator_(options.seed),
        store_(MapStore::Create(map_path)),
        site_(BenchSiteOrigin(options.num_tiles)),
        ecef_from_site_(EcefFromEnu(site_)),
        centers_(BenchTileCenters(options.num_tiles)) {
    for (const Eigen::Vector2d& center : centers_) {
      const Eigen::Vector3d x_in_ecef =
          ecef_from_site_ * Eigen::Vector3d(center.x(), center.y(), 0);
      tile_ids_.push_back(TileId::Containing(GeodeticFromEcef(x_in_ecef)));
    }
  }

  std::vector<EvalQuery> Build(const std::function<void(int, int)>& progress) {
    MapUpdate update = store_.BeginUpdate();
    const Codebook codebook = MakeCodebook();
    codec_ = std::make_unique<DescriptorCodec>(std::make_shared<const Codebook>(codebook));
    codebook_id_ = update.AddCodebook(codebook);
    SessionRecord session;
    session.name = "bench";
    session.source = "synthetic";
    session.num_images = int64_t{options_.keyframes_per_tile} * options_.num_tiles;
    session.num_landmarks = int64_t{options_.landmarks_per_tile} * options_.num_tiles;
    session_id_ = update.AddSession(session);
    for (int tile = 0; tile < options_.num_tiles; ++tile) {
      AddTile(tile, &update);
      if (progress) {
        progress(tile + 1, options_.num_tiles);
      }
    }
    update.Publish();
    return MakeQueries();
  }

 private:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator_);
  }
  double Normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(generator_); }

  // Trains the codebook as ingest does, on landmarks that are not in the map but look alike.
  Codebook MakeCodebook() const {
    Reconstruction sample;
    sample.cameras.emplace_back();
    sample.images.resize(kTrainingObservations);
    sample.landmarks.resize(kTrainingLandmarks);
    const uint64_t first_number = NumberAfterMap();
    for (int image = 0; image < kTrainingObservations; ++image) {
      FeatureSet features;
      sample.images[image].name = fmt::format("{}", image);
      features.keypoints.resize(kTrainingLandmarks);
      features.descriptors.resize(kTrainingLandmarks, DescriptorModel::kDim);
      for (int i = 0; i < kTrainingLandmarks; ++i) {
        features.descriptors.row(i) = sift_.Describe(Look(first_number + i, image));
        sample.landmarks[i].x_in_world = Eigen::Vector3d::Zero();
        sample.landmarks[i].observations.push_back({image, i});
      }
      sample.images[image].features = std::move(features);
    }
    CodebookOptions codebook_options;
    codebook_options.seed = options_.seed;
    return TrainCodebook(sample, codebook_options);
  }

  // Returns the first number that no landmark of the map has.
  uint64_t NumberAfterMap() const {
    return uint64_t(options_.num_tiles) * uint64_t(options_.landmarks_per_tile);
  }

  void AddTile(int tile_idx, MapUpdate* update) {
    std::vector<BenchLandmark> landmarks;
    landmarks.reserve(options_.landmarks_per_tile);
    for (int i = 0; i < options_.landmarks_per_tile; ++i) {
      landmarks.push_back(RandomLandmark(centers_[tile_idx], &generator_));
      landmarks.back().number =
          uint64_t(tile_idx) * uint64_t(options_.landmarks_per_tile) + uint64_t(i);
    }
    const Rigid3d tile_from_site =
        EcefFromEnu(tile_ids_[tile_idx].Anchor()).Inverse() * ecef_from_site_;
    std::vector<Eigen::Vector3f> x_in_tile;
    for (const BenchLandmark& landmark : landmarks) {
      x_in_tile.push_back(QuantizePosition(tile_from_site * landmark.x_in_site));
    }
    std::vector<BenchLandmark> ordered;
    Tile tile;
    for (const uint32_t i : MortonOrder(x_in_tile)) {
      ordered.push_back(landmarks[i]);
      tile.x_in_tile.push_back(x_in_tile[i]);
    }
    tile.id = tile_ids_[tile_idx];
    FillLandmarks(ordered, update, &tile);
    FillCodes(ordered, &tile);
    FillKeyframes(tile_idx, ordered, tile_from_site, update, &tile);
    PutTile(tile, update);
    KeepNearCrossing(ordered);
  }

  void FillLandmarks(const std::vector<BenchLandmark>& landmarks, MapUpdate* update, Tile* tile) {
    const uint64_t first_id = Value(update->ReserveLandmarkIds(landmarks.size()));
    tile->sigma_codes.assign(landmarks.size(), SigmaCode(kLandmarkSigmaM));
    tile->history.assign(landmarks.size(), {session_id_, 2, 2});
    tile->history_begin.resize(landmarks.size() + 1);
    std::iota(tile->history_begin.begin(), tile->history_begin.end(), 0u);
    tile->descriptor_begin.push_back(0);
    for (size_t i = 0; i < landmarks.size(); ++i) {
      const BenchLandmark& landmark = landmarks[i];
      tile->landmark_ids.push_back(LandmarkId{first_id + i});
      for (int j = 0; j < landmark.num_descriptors; ++j) {
        const double behind_m = Uniform(kBenchMinViewM, kBenchMaxViewM);
        const Eigen::Vector3d camera = landmark.lane.At(
            landmark.along_m - landmark.lane.travel_sign * behind_m, kBenchCameraHeightM);
        const Eigen::Vector3d to_camera = camera - landmark.x_in_site;
        tile->azimuth_codes.push_back(AzimuthCode(std::atan2(to_camera.y(), to_camera.x())));
        tile->orientation_codes.push_back(
            OrientationCode(landmark.orientation_rad + Normal(kOrientationNoiseRad)));
        tile->size_codes.push_back(SizeCode(landmark.size_m * std::exp(Normal(kLogSizeNoise))));
      }
      tile->descriptor_begin.push_back(static_cast<uint32_t>(tile->azimuth_codes.size()));
    }
    tile->weight_codes.assign(tile->azimuth_codes.size(), WeightCode(1.0));
  }

  void FillCodes(const std::vector<BenchLandmark>& landmarks, Tile* tile) const {
    tile->codebook_id = codebook_id_;
    tile->code_size = codec_->codebook().num_subspaces;
    DescriptorMatrix batch(kEncodeBatch, DescriptorModel::kDim);
    size_t batch_size = 0;
    const auto encode_batch = [&] {
      const std::vector<uint8_t> codes =
          codec_->Encode(codec_->Project(batch.topRows(static_cast<Eigen::Index>(batch_size))));
      tile->codes.insert(tile->codes.end(), codes.begin(), codes.end());
      batch_size = 0;
    };
    for (const BenchLandmark& landmark : landmarks) {
      for (int j = 0; j < landmark.num_descriptors; ++j) {
        batch.row(static_cast<Eigen::Index>(batch_size++)) =
            sift_.Describe(Look(landmark.number, j));
        if (batch_size == kEncodeBatch) {
          encode_batch();
        }
      }
    }
    encode_batch();
  }

  // Places keyframes in random lanes. Each sees some of the landmarks ahead.
  void FillKeyframes(int tile_idx, const std::vector<BenchLandmark>& landmarks,
                     const Rigid3d& tile_from_site, MapUpdate* update, Tile* tile) {
    LaneIndex lanes(landmarks);
    tile->keyframe_begin.push_back(0);
    for (int k = 0; k < options_.keyframes_per_tile; ++k) {
      const BenchLandmark place = RandomLandmark(centers_[tile_idx], &generator_);
      const std::vector<uint32_t> seen =
          lanes.Sample(place.lane, place.along_m, kLandmarksPerView, &generator_);
      const Rigid3d cam_from_site =
          CamFromSite(place.lane.At(place.along_m, kBenchCameraHeightM), place.lane.YawRad(), 0.0);
      AddKeyframe(tile_from_site, cam_from_site, update, tile);
      tile->keyframe_landmarks.insert(tile->keyframe_landmarks.end(), seen.begin(), seen.end());
      tile->keyframe_begin.push_back(static_cast<uint32_t>(tile->keyframe_landmarks.size()));
    }
  }

  void AddKeyframe(const Rigid3d& tile_from_site, const Rigid3d& cam_from_site, MapUpdate* update,
                   Tile* tile) {
    KeyframeRecord record;
    record.session_id = session_id_;
    record.tile_id = tile->id;
    record.image_name = fmt::format("{}/{:06}", tile->id.ToString(), tile->num_keyframes());
    record.camera = camera_;
    record.cam_from_ecef = cam_from_site * ecef_from_site_.Inverse();
    const KeyframeId id = update->AddKeyframe(record);
    tile->keyframes.push_back({id, session_id_, cam_from_site * tile_from_site.Inverse()});
  }

  void PutTile(const Tile& tile, MapUpdate* update) const {
    TileRecord record;
    record.tile_id = tile.id;
    record.codebook_id = codebook_id_;
    record.num_landmarks = static_cast<int64_t>(tile.num_landmarks());
    record.num_descriptors = static_cast<int64_t>(tile.num_descriptors());
    record.num_keyframes = static_cast<int64_t>(tile.num_keyframes());
    record.min_h_m = site_.h_m + kBenchCameraHeightM;
    record.max_h_m = record.min_h_m;
    record.landmark_bounds = tile.id.Bounds();
    update->PutTile(record, EncodeTile(tile, MakeTileLists(codec_->codebook(), tile.codes,
                                                           InvertedListsOptions())));
  }

  // Keeps the landmarks that a query can see.
  void KeepNearCrossing(const std::vector<BenchLandmark>& landmarks) {
    std::copy_if(landmarks.begin(), landmarks.end(), std::back_inserter(near_crossing_),
                 [](const BenchLandmark& landmark) {
                   return landmark.lane == QueryLane(landmark.lane.travel_sign) &&
                          std::abs(landmark.along_m) < 2.0 * kBenchMaxViewM;
                 });
  }

  std::vector<EvalQuery> MakeQueries() {
    std::vector<EvalQuery> queries;
    for (int i = 0; i < options_.num_queries; ++i) {
      queries.push_back(MakeQuery(i));
    }
    PriorNoiseOptions noise;
    noise.position_sigma_m = 5.0;  // Keeps all tiles in the search, wherever the prior is.
    noise.seed = options_.seed;
    AddNoisyPriors(noise, &queries);
    return queries;
  }

  EvalQuery MakeQuery(int query_idx) {
    const BenchLane lane = QueryLane(query_idx % 2 == 0 ? 1 : -1);
    const double along_m = Uniform(-5.0, 5.0);
    const Eigen::Vector3d center = lane.At(along_m, kBenchCameraHeightM + Normal(0.1)) +
                                   Eigen::Vector3d(0.0, Uniform(-2.0, 2.0), 0.0);
    const Rigid3d cam_from_site =
        CamFromSite(center, lane.YawRad() + Uniform(-0.2, 0.2), Uniform(0.0, 0.2));
    std::vector<const BenchLandmark*> visible;
    for (const BenchLandmark& landmark : near_crossing_) {
      const double ahead_m = lane.AheadM(along_m, landmark.along_m);
      const auto pixel = camera_.Project(cam_from_site * landmark.x_in_site);
      if (landmark.lane == lane && ahead_m >= kBenchMinViewM && ahead_m <= kBenchMaxViewM &&
          pixel && camera_.Contains(*pixel)) {
        visible.push_back(&landmark);
      }
    }
    std::vector<const BenchLandmark*> seen;
    std::sample(visible.begin(), visible.end(), std::back_inserter(seen),
                static_cast<size_t>(options_.mapped_fraction * options_.num_keypoints), generator_);

    EvalQuery query;
    query.name = fmt::format("query_{:02}", query_idx);
    query.cam_from_ecef = cam_from_site * ecef_from_site_.Inverse();
    query.query.id = query.name;
    query.query.camera = camera_;
    FillFeatures(query_idx, cam_from_site, seen, &query.query.features);
    return query;
  }

  // Fills in the seen landmarks first, then clutter with descriptors of landmarks that are not in
  // the map.
  void FillFeatures(int query_idx, const Rigid3d& cam_from_site,
                    const std::vector<const BenchLandmark*>& seen, FeatureSet* features) {
    features->descriptors.resize(options_.num_keypoints, DescriptorModel::kDim);
    const uint64_t clutter = NumberAfterMap() + kTrainingLandmarks +
                             uint64_t(query_idx) * uint64_t(options_.num_keypoints);
    for (int i = 0; i < options_.num_keypoints; ++i) {
      if (i < static_cast<int>(seen.size())) {
        features->keypoints.push_back(SeeLandmark(cam_from_site, *seen[i]));
        features->descriptors.row(i) =
            sift_.Describe(Look(seen[i]->number, kQueryObservation + uint64_t(query_idx)));
      } else {
        features->keypoints.push_back({static_cast<float>(Uniform(0.0, camera_.width_px())),
                                       static_cast<float>(Uniform(0.0, camera_.height_px())),
                                       static_cast<float>(Uniform(1.0, 8.0)),
                                       static_cast<float>(Uniform(-kPi, kPi))});
        features->descriptors.row(i) = sift_.Describe(Look(clutter + uint64_t(i), 0));
      }
    }
  }

  Keypoint SeeLandmark(const Rigid3d& cam_from_site, const BenchLandmark& landmark) {
    const Eigen::Vector3d x_in_cam = cam_from_site * landmark.x_in_site;
    const Eigen::Vector2d pixel = camera_.Project(x_in_cam).value();
    Keypoint keypoint;
    keypoint.x_px = static_cast<float>(pixel.x() + Normal(kPixelNoisePx));
    keypoint.y_px = static_cast<float>(pixel.y() + Normal(kPixelNoisePx));
    keypoint.scale_px = static_cast<float>(landmark.size_m * std::exp(Normal(kLogSizeNoise)) *
                                           camera_.focal_px() / x_in_cam.norm());
    // The rectified orientation is the keypoint's orientation minus the orientation of gravity
    // there.
    const Eigen::Vector3d down_in_cam = cam_from_site.rotation * -Eigen::Vector3d::UnitZ();
    const double rectified_zero =
        GravityRectifiedOrientationRad(camera_, keypoint, down_in_cam).value_or(0.0);
    keypoint.orientation_rad = static_cast<float>(
        WrapAngleRad(landmark.orientation_rad + Normal(kOrientationNoiseRad) - rectified_zero));
    return keypoint;
  }

  BenchWorldOptions options_;
  DescriptorModel sift_;
  std::mt19937_64 generator_;
  MapStore store_;
  Geodetic site_;
  Rigid3d ecef_from_site_;
  Camera camera_;
  std::vector<Eigen::Vector2d> centers_;  // Tile centers, in site.
  std::vector<TileId> tile_ids_;
  std::unique_ptr<DescriptorCodec> codec_;
  CodebookId codebook_id_{};
  SessionId session_id_{};
  std::vector<BenchLandmark> near_crossing_;
};

}  // namespace

void BenchWorldOptions::Validate() const {
  RequireOption(num_tiles == 1 || num_tiles == 2 || num_tiles == 4, "num_tiles must be 1, 2 or 4");
  RequireWithin("landmarks_per_tile", landmarks_per_tile, 1000, 2'000'000);
  RequireWithin("keyframes_per_tile", keyframes_per_tile, 1, 10'000);
  RequireWithin("num_keypoints", num_keypoints, 10, 5000);
  RequireOption(mapped_fraction > 0.0 && mapped_fraction <= 1.0,
                "mapped_fraction must lie in (0, 1]");
  RequireWithin("num_queries", num_queries, 1, 10'000);
}

std::vector<EvalQuery> BuildBenchWorld(const BenchWorldOptions& options,
                                       const std::string& map_path,
                                       const std::function<void(int, int)>& progress) {
  options.Validate();
  return WorldBuilder(options, map_path).Build(progress);
}

}  // namespace cairn
