#include "ingest/tiles/link_landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/angles.h"
#include "core/check.h"
#include "core/frames.h"
#include "core/geodesy.h"
#include "core/keypoint_shape.h"
#include "ingest/tiles/landmark_grid.h"
#include "ingest/tiles/tile_option_visit.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// An observation of a landmark by a photo of the session.
struct SessionObservation {
  uint32_t landmark_idx = 0;
  int image_idx = 0;
  int keypoint_idx = 0;
  Eigen::Index row = 0;  // Of the projected descriptors.
};

// Largest distance at which positions are compared, meters; farther landmarks are never linked.
constexpr double kMaxGateM = 3.0;
// Known landmarks closer than this are one thing that the map holds twice.
constexpr float kSameThingM = 0.15f;
constexpr double kReferenceFocalPx = 500.0;

double AngleBetween(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * kPi));
}

class LinkProposer {
 public:
  LinkProposer(const Reconstruction& reconstruction, const PlacedSession& session,
               const Tile& known, const DescriptorCodec& codec, const LinkOptions& options)
      : reconstruction_(reconstruction),
        session_(session),
        known_(known),
        options_(options),
        ecef_from_tile_(EcefFromEnu(known.id.Anchor())),
        grid_(&known, kMaxGateM),  // A search visits 27 cells.
        known_descriptors_(
            codec.Decode(known.codes.data(), static_cast<int>(known.num_descriptors()))) {
    const auto distance =
        static_cast<float>(SameLandmarkDistance(codec.codebook(), options.max_distance_quantile));
    max_sq_distance_ = distance * distance;
    GatherObservations(codec);
  }

  std::vector<LinkProposal> Propose() {
    std::vector<LinkProposal> proposals;
    for (auto begin = observations_.begin(); begin != observations_.end();) {
      const auto end = std::find_if(begin, observations_.end(), [&](const auto& observation) {
        return observation.landmark_idx != begin->landmark_idx;
      });
      if (const auto proposal = ProposeFor({begin, end})) {
        proposals.push_back(*proposal);
      }
      begin = end;
    }
    return proposals;
  }

 private:
  void GatherObservations(const DescriptorCodec& codec) {
    const std::vector<int>& images = session_.images_of_tile.at(known_.id);
    size_t num_observations = 0;
    for (const int image_idx : images) {
      num_observations += session_.observations_of_image[image_idx].size();
    }
    projected_.resize(num_observations, codec.codebook().projected_dim());
    for (const int image_idx : images) {
      const auto& observations = session_.observations_of_image[image_idx];
      const PackedFeatures& features = reconstruction_.images[image_idx].features;
      FeatureSet seen;
      seen.space = features.space;
      seen.descriptors = features.descriptors.Rows(KeypointsOf(observations)).Unpacked();
      const auto first_row = static_cast<Eigen::Index>(observations_.size());
      for (size_t i = 0; i < observations.size(); ++i) {
        observations_.push_back({observations[i].landmark_idx, image_idx,
                                 observations[i].keypoint_idx,
                                 first_row + static_cast<Eigen::Index>(i)});
      }
      projected_.middleRows(first_row, seen.descriptors.rows()) = codec.ProjectFeatures(seen);
      down_in_cam_[image_idx] = DownInCamera(session_.cam_from_ecef[image_idx]);
    }
    std::stable_sort(observations_.begin(), observations_.end(),
                     [](const auto& a, const auto& b) { return a.landmark_idx < b.landmark_idx; });
  }

  static Eigen::Vector3d DownInCamera(const Rigid3d& cam_from_ecef) {
    const Geodetic position = GeodeticFromEcef(cam_from_ecef.Inverse().translation);
    return cam_from_ecef.rotation * (EcefFromEnu(position).rotation * DownInEnu());
  }

  // Direction, physical size and orientation of an observation, as tiles have them.
  struct Attributes {
    double azimuth_rad = 0.0;
    std::optional<double> log2_size;
    std::optional<double> orientation_rad;
  };

  Attributes AttributesOf(const SessionObservation& observation,
                          const Eigen::Vector3d& x_in_tile) const {
    const ReconImage& image = reconstruction_.images[observation.image_idx];
    const Camera& camera = reconstruction_.cameras[image.camera_idx];
    const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
    const Rigid3d cam_from_tile = session_.cam_from_ecef[observation.image_idx] * ecef_from_tile_;
    const Eigen::Vector3d to_camera = cam_from_tile.Inverse().translation - x_in_tile;
    Attributes attributes;
    attributes.azimuth_rad = std::atan2(to_camera.y(), to_camera.x());
    if (HasScale(keypoint)) {
      const double size_m = keypoint.scale_px / camera.focal_px() * to_camera.norm();
      attributes.log2_size = std::log2(std::max(size_m, 1e-6));
    }
    attributes.orientation_rad =
        GravityRectifiedOrientationRad(camera, keypoint, down_in_cam_.at(observation.image_idx));
    return attributes;
  }

  bool IsComparable(const Attributes& own, uint32_t descriptor_idx) const {
    if (AngleBetween(own.azimuth_rad, AzimuthFromCode(known_.azimuth_codes[descriptor_idx])) >
        options_.max_azimuth_rad) {
      return false;
    }
    const double known_size_m = SizeFromCode(known_.size_codes[descriptor_idx]);
    if (own.log2_size && known_size_m > 0.0 &&
        std::abs(*own.log2_size - std::log2(known_size_m)) > options_.max_log2_size) {
      return false;
    }
    const uint8_t orientation_code = known_.orientation_codes[descriptor_idx];
    return !own.orientation_rad || orientation_code == kNoOrientation ||
           AngleBetween(*own.orientation_rad, OrientationFromCode(orientation_code)) <=
               options_.max_orientation_rad;
  }

  // The best known landmark for the observations at one landmark of the session.
  std::optional<LinkProposal> ProposeFor(std::span<const SessionObservation> observations) {
    const PlacedLandmark& landmark = session_.landmarks[observations.front().landmark_idx];
    const Eigen::Vector3d x_in_tile = ecef_from_tile_.Inverse() * landmark.x_in_ecef;
    std::vector<Attributes> attributes;
    for (const SessionObservation& observation : observations) {
      attributes.push_back(AttributesOf(observation, x_in_tile));
    }

    candidates_.clear();
    grid_.ForEachWithin(x_in_tile, kMaxGateM, [&](uint32_t known_idx, double distance_m) {
      if (!IsNear(landmark, known_idx, distance_m)) {
        return;
      }
      const float sq_distance = SquaredDistance(observations, attributes, known_idx);
      if (sq_distance > max_sq_distance_ || !FitsImages(observations, known_idx)) {
        return;
      }
      candidates_.push_back({sq_distance, known_.landmark_ids[known_idx], known_idx});
    });
    if (candidates_.empty()) {
      return std::nullopt;
    }
    const Candidate best = *std::min_element(candidates_.begin(), candidates_.end());
    if (HasRival(best)) {
      return std::nullopt;
    }
    return LinkProposal{observations.front().landmark_idx, best.id, best.sq_distance};
  }

  struct Candidate {
    float sq_distance = 0.0f;
    LandmarkId id{};
    uint32_t known_idx = 0;

    bool operator<(const Candidate& other) const {
      return std::tie(sq_distance, id) < std::tie(other.sq_distance, other.id);
    }
  };

  // Whether another thing looks nearly as similar.
  bool HasRival(const Candidate& best) const {
    return std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& other) {
      const float distance_m =
          (known_.x_in_tile[other.known_idx] - known_.x_in_tile[best.known_idx]).norm();
      return distance_m > kSameThingM && options_.max_ratio * other.sq_distance < best.sq_distance;
    });
  }

  bool IsNear(const PlacedLandmark& landmark, uint32_t known_idx, double distance_m) const {
    const double known_sigma_m = SigmaFromCode(known_.sigma_codes[known_idx]);
    const double sigma_m =
        std::sqrt(landmark.sigma_m * landmark.sigma_m + known_sigma_m * known_sigma_m +
                  options_.placement_sigma_m * options_.placement_sigma_m);
    return distance_m <= options_.max_distance_sigmas * sigma_m;
  }

  // Median over the observations of the distance to the nearest comparable descriptor.
  float SquaredDistance(std::span<const SessionObservation> observations,
                        const std::vector<Attributes>& attributes, uint32_t known_idx) {
    distances_.clear();
    for (size_t i = 0; i < observations.size(); ++i) {
      float least = std::numeric_limits<float>::max();
      for (uint32_t d = known_.descriptor_begin[known_idx];
           d < known_.descriptor_begin[known_idx + 1]; ++d) {
        if (!IsComparable(attributes[i], d)) {
          continue;
        }
        least = std::min(
            least, (projected_.row(observations[i].row) - known_descriptors_.row(d)).squaredNorm());
      }
      distances_.push_back(least);
    }
    const auto middle = distances_.begin() + static_cast<std::ptrdiff_t>(distances_.size() / 2);
    std::nth_element(distances_.begin(), middle, distances_.end());
    return *middle;
  }

  // Whether the known landmark stands where the session's keypoints are.
  bool FitsImages(std::span<const SessionObservation> observations, uint32_t known_idx) {
    const Eigen::Vector3d x_in_ecef = ecef_from_tile_ * known_.x_in_tile[known_idx].cast<double>();
    const double sigma_m =
        std::hypot(SigmaFromCode(known_.sigma_codes[known_idx]), options_.placement_sigma_m);
    errors_.clear();
    for (const SessionObservation& observation : observations) {
      const ReconImage& image = reconstruction_.images[observation.image_idx];
      const Camera& camera = reconstruction_.cameras[image.camera_idx];
      const Eigen::Vector3d x_in_cam = session_.cam_from_ecef[observation.image_idx] * x_in_ecef;
      const auto pixel = x_in_cam.z() > 0.0 ? camera.Project(x_in_cam) : std::nullopt;
      if (!pixel) {
        errors_.push_back(std::numeric_limits<double>::max());
        continue;
      }
      const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
      const double sigma_px =
          std::hypot(options_.keypoint_sigma_px * camera.focal_px() / kReferenceFocalPx,
                     camera.focal_px() * sigma_m / x_in_cam.norm());
      errors_.push_back((*pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px)).norm() / sigma_px);
    }
    const auto middle = errors_.begin() + static_cast<std::ptrdiff_t>(errors_.size() / 2);
    std::nth_element(errors_.begin(), middle, errors_.end());
    return *middle <= options_.max_error_sigmas;
  }

  const Reconstruction& reconstruction_;
  const PlacedSession& session_;
  const Tile& known_;
  const LinkOptions& options_;
  Rigid3d ecef_from_tile_;
  LandmarkGrid grid_;
  DescriptorMatrix known_descriptors_;
  float max_sq_distance_ = 0.0f;
  std::vector<SessionObservation> observations_;  // By landmark.
  DescriptorMatrix projected_;                    // A row an observation.
  std::map<int, Eigen::Vector3d> down_in_cam_;    // By image.
  std::vector<Candidate> candidates_;             // Scratch.
  std::vector<float> distances_;                  // Scratch.
  std::vector<double> errors_;                    // Scratch.
};

}  // namespace

void LinkOptions::Validate() const { CheckOptions("ingest.upkeep.linking", *this); }

std::vector<LinkProposal> ProposeLinks(const Reconstruction& reconstruction,
                                       const PlacedSession& session, const Tile& known,
                                       const DescriptorCodec& codec, const LinkOptions& options) {
  if (known.num_landmarks() == 0 || !session.images_of_tile.contains(known.id)) {
    return {};
  }
  return LinkProposer(reconstruction, session, known, codec, options).Propose();
}

std::vector<LandmarkId> ResolveLinks(const Reconstruction& reconstruction,
                                     const PlacedSession& session,
                                     std::vector<LinkProposal> proposals) {
  std::sort(proposals.begin(), proposals.end(), [](const LinkProposal& a, const LinkProposal& b) {
    return std::tie(a.sq_distance, a.landmark_idx, a.known_id) <
           std::tie(b.sq_distance, b.landmark_idx, b.known_id);
  });
  std::vector<LandmarkId> ids(session.landmarks.size(), LandmarkId{});
  std::unordered_map<uint64_t, std::set<int>> images_of_known;
  for (const LinkProposal& proposal : proposals) {
    if (ids[proposal.landmark_idx] != LandmarkId{}) {
      continue;
    }
    const auto& observations =
        reconstruction.landmarks[session.landmarks[proposal.landmark_idx].recon_idx].observations;
    std::set<int>& images = images_of_known[Value(proposal.known_id)];
    const bool is_seen_twice = std::any_of(
        observations.begin(), observations.end(),
        [&](const auto& observation) { return images.contains(observation.image_idx); });
    if (is_seen_twice) {
      continue;
    }
    for (const auto& observation : observations) {
      images.insert(observation.image_idx);
    }
    ids[proposal.landmark_idx] = proposal.known_id;
  }
  return ids;
}

PlacedSession JoinLinked(const PlacedSession& session, std::vector<LandmarkId>* ids) {
  CAIRN_CHECK(ids->size() == session.landmarks.size(), "there must be one id for each landmark");
  PlacedSession joined = session;
  joined.landmarks.clear();
  std::vector<uint32_t> new_idx(session.landmarks.size());
  std::vector<LandmarkId> joined_ids;
  std::unordered_map<uint64_t, uint32_t> idx_of_id;
  for (uint32_t i = 0; i < session.landmarks.size(); ++i) {
    const auto next = static_cast<uint32_t>(joined.landmarks.size());
    const LandmarkId id = (*ids)[i];
    new_idx[i] = id == LandmarkId{} ? next : idx_of_id.try_emplace(Value(id), next).first->second;
    if (new_idx[i] == next) {
      joined.landmarks.push_back(session.landmarks[i]);
      joined_ids.push_back(id);
      continue;
    }
    PlacedLandmark& same = joined.landmarks[new_idx[i]];
    const PlacedLandmark& other = session.landmarks[i];
    const double information = 1.0 / (same.sigma_m * same.sigma_m);
    const double other_information = 1.0 / (other.sigma_m * other.sigma_m);
    same.x_in_ecef = (information * same.x_in_ecef + other_information * other.x_in_ecef) /
                     (information + other_information);
    same.sigma_m = 1.0 / std::sqrt(information + other_information);
  }
  for (std::vector<PlacedObservation>& observations : joined.observations_of_image) {
    for (PlacedObservation& observation : observations) {
      observation.landmark_idx = new_idx[observation.landmark_idx];
    }
  }
  *ids = std::move(joined_ids);
  return joined;
}

}  // namespace cairn
