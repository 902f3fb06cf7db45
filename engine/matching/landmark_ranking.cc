#include "engine/matching/landmark_ranking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "engine/matching/distance_statistics.h"

namespace cairn {
namespace {

// Chords are rounded; the hard filter lets a difference of exactly the bound pass.
constexpr float kChordTolerance = 1e-5f;

// Unit vector of each orientation code; zero for kNoOrientation.
std::array<Eigen::Vector2f, 256> MakeCodeDirections() {
  std::array<Eigen::Vector2f, 256> directions;
  directions.fill(Eigen::Vector2f::Zero());
  for (int code = 0; code < kNoOrientation; ++code) {
    const double angle_rad = OrientationFromCode(static_cast<uint8_t>(code));
    directions[code] = Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad)).cast<float>();
  }
  return directions;
}

const std::array<Eigen::Vector2f, 256>& CodeDirections() {
  static const std::array<Eigen::Vector2f, 256> directions = MakeCodeDirections();
  return directions;
}

// Keypoints whose hits are worked through together.
constexpr size_t kKeypointsPerBatch = 16;
// Hits of a keypoint that are added first.
constexpr size_t kNearestHits = 8;

std::span<DescriptorHit> HitsOfFirstKeypoint(std::span<DescriptorHit> hits) {
  size_t size = 1;
  while (size < hits.size() && hits[size].query_idx == hits[0].query_idx) {
    ++size;
  }
  return hits.first(size);
}

// Returns how many of the nearest hits now come first.
size_t MoveNearestToFront(std::span<DescriptorHit> hits) {
  if (hits.size() <= kNearestHits) {
    return hits.size();
  }
  std::nth_element(
      hits.begin(), hits.begin() + kNearestHits - 1, hits.end(),
      [](const DescriptorHit& a, const DescriptorHit& b) { return a.sq_distance < b.sq_distance; });
  return kNearestHits;
}

}  // namespace

LandmarkRanking::LandmarkRanking(const QueryContext& query, const Codebook& codebook,
                                 const MatchingOptions& options)
    : query_(query),
      options_(options),
      keypoint_directions_(query.num_keypoints(), Eigen::Vector2f::Zero()),
      neighbors_(size_t{1} * query.num_keypoints() * options.max_neighbors),
      num_neighbors_(query.num_keypoints(), 0) {
  const double median_distance = SameLandmarkDistance(codebook, 0.5);
  const double sq_median = median_distance * median_distance;
  orientation_factor_ = static_cast<float>(options.orientation_weight * sq_median);
  if (query.region.has_prior && query.region.prior_sigma_m > 0.0) {
    position_factor_ = static_cast<float>(options.position_weight * sq_median);
    max_sq_excess_ =
        static_cast<float>(options.max_position_excess_sigmas * options.max_position_excess_sigmas);
    uses_position_ =
        options.position_weight > 0.0 || std::isfinite(options.max_position_excess_sigmas);
  }
  if (options.max_orientation_difference_rad < std::numbers::pi) {
    max_sq_chord_ =
        static_cast<float>(2.0 - 2.0 * std::cos(options.max_orientation_difference_rad)) +
        kChordTolerance;
  }
  for (int i = 0; i < query.num_keypoints(); ++i) {
    if (const std::optional<float> angle_rad = query.gravity_orientations_rad[i]) {
      keypoint_directions_[i] = Eigen::Vector2f(std::cos(*angle_rad), std::sin(*angle_rad));
    }
  }
}

// First some of the nearest hits of each keypoint, which bound what the others can still change.
void LandmarkRanking::Add(const TileView& view, int tile_idx, std::span<DescriptorHit> hits) {
  std::array<std::span<DescriptorHit>, kKeypointsPerBatch> batch;
  for (size_t begin = 0; begin < hits.size();) {
    useful_hits_.clear();
    size_t size = 0;
    for (; size < kKeypointsPerBatch && begin < hits.size(); ++size) {
      batch[size] = HitsOfFirstKeypoint(hits.subspan(begin));
      begin += batch[size].size();
      const size_t num_nearest = MoveNearestToFront(batch[size]);
      const auto nearest = batch[size].first(num_nearest);
      useful_hits_.insert(useful_hits_.end(), nearest.begin(), nearest.end());
      batch[size] = batch[size].subspan(num_nearest);
    }
    AddHits(view, tile_idx, useful_hits_);
    useful_hits_.clear();
    for (size_t i = 0; i < size; ++i) {
      for (const DescriptorHit& hit : batch[i]) {
        if (hit.sq_distance <= MaxUsefulSqDistance(hit.query_idx)) {
          useful_hits_.push_back(hit);
        }
      }
    }
    AddHits(view, tile_idx, useful_hits_);
  }
}

// In three steps, each of which asks for the memory that the next one reads: the attributes of a
// hit lie anywhere in the tile.
void LandmarkRanking::AddHits(const TileView& view, int tile_idx,
                              std::span<const DescriptorHit> hits) {
  const Tile& tile = view.tile->tile();
  const std::vector<uint32_t>& landmark_of_descriptor = view.tile->landmark_of_descriptor();
  for (const DescriptorHit& hit : hits) {
    __builtin_prefetch(&tile.orientation_codes[hit.descriptor_idx]);
    __builtin_prefetch(&landmark_of_descriptor[hit.descriptor_idx]);
  }
  candidates_.clear();
  for (const DescriptorHit& hit : hits) {
    const float sq_chord =
        SqOrientationChord(hit.query_idx, tile.orientation_codes[hit.descriptor_idx]);
    const float sq_distance = hit.sq_distance + orientation_factor_ * sq_chord;
    // Prior terms only add.
    if (sq_chord <= max_sq_chord_ && sq_distance <= MaxUsefulSqDistance(hit.query_idx)) {
      const uint32_t landmark_idx = landmark_of_descriptor[hit.descriptor_idx];
      candidates_.push_back(
          {hit.query_idx, {sq_distance, tile_idx, landmark_idx, hit.descriptor_idx, {}}});
      __builtin_prefetch(&tile.landmark_ids[landmark_idx]);
      __builtin_prefetch(&tile.x_in_tile[landmark_idx]);
    }
  }
  for (Candidate& candidate : candidates_) {
    Neighbor& neighbor = candidate.neighbor;
    neighbor.landmark_id = tile.landmark_ids[neighbor.landmark_idx];
    if (uses_position_) {
      const float sq_excess = SqPositionExcess(view, neighbor.landmark_idx);
      if (sq_excess > max_sq_excess_) {
        continue;
      }
      neighbor.sq_distance += position_factor_ * sq_excess;
    }
    Insert(candidate.keypoint_idx, neighbor);
  }
}

double LandmarkRanking::MaxUsefulDistance(uint32_t keypoint_idx) const {
  // Distances are rounded to floats, of which the next one still counts.
  constexpr double kRounding = 1.0 + 1e-6;
  return kRounding * std::sqrt(static_cast<double>(MaxUsefulSqDistance(keypoint_idx)));
}

bool LandmarkRanking::IsCloser(const Neighbor& a, const Neighbor& b) {
  return std::tie(a.sq_distance, a.landmark_id, a.tile_idx, a.descriptor_idx) <
         std::tie(b.sq_distance, b.landmark_id, b.tile_idx, b.descriptor_idx);
}

float LandmarkRanking::MaxUsefulSqDistance(uint32_t keypoint_idx) const {
  return num_neighbors_[keypoint_idx] < options_.max_neighbors
             ? std::numeric_limits<float>::infinity()
             : neighbors_[(size_t{keypoint_idx} + 1) * options_.max_neighbors - 1].sq_distance;
}

float LandmarkRanking::SqOrientationChord(uint32_t keypoint_idx, uint8_t orientation_code) const {
  const Eigen::Vector2f& a = keypoint_directions_[keypoint_idx];
  const Eigen::Vector2f& b = CodeDirections()[orientation_code];
  if (a.isZero(0.0f) || b.isZero(0.0f)) {
    return 0.0f;
  }
  return (a - b).squaredNorm();
}

float LandmarkRanking::SqPositionExcess(const TileView& view, uint32_t landmark_idx) const {
  const Eigen::Vector3d x_in_anchor =
      view.anchor_from_tile * view.tile->tile().x_in_tile[landmark_idx].cast<double>();
  const double distance_m = (x_in_anchor.head<2>() - query_.region.prior_xy_in_anchor).norm();
  const double excess =
      std::max(0.0, distance_m - options_.viewing_distance_m) / query_.region.prior_sigma_m;
  return static_cast<float>(excess * excess);
}

void LandmarkRanking::Insert(uint32_t keypoint_idx, const Neighbor& neighbor) {
  const std::span<Neighbor> row(neighbors_.data() + size_t{keypoint_idx} * options_.max_neighbors,
                                options_.max_neighbors);
  int& count = num_neighbors_[keypoint_idx];
  // The entry that the neighbour displaces: its landmark's, else a free one, else the last.
  int place = 0;
  while (place < count && row[place].landmark_id != neighbor.landmark_id) {
    ++place;
  }
  if (place < count || count == options_.max_neighbors) {
    place = std::min(place, count - 1);
    if (!IsCloser(neighbor, row[place])) {
      return;
    }
  } else {
    ++count;
  }
  for (; place > 0 && IsCloser(neighbor, row[place - 1]); --place) {
    row[place] = row[place - 1];
  }
  row[place] = neighbor;
}

std::vector<Correspondence> LandmarkRanking::Correspondences(
    const std::vector<TileView>& tiles) const {
  std::vector<Correspondence> correspondences;
  for (int keypoint_idx = 0; keypoint_idx < query_.num_keypoints(); ++keypoint_idx) {
    for (int i = 0; i < num_neighbors_[keypoint_idx]; ++i) {
      const Neighbor& neighbor = neighbors_[size_t{1} * keypoint_idx * options_.max_neighbors + i];
      const TileView& view = tiles[neighbor.tile_idx];
      const Tile& tile = view.tile->tile();
      correspondences.push_back(
          {.keypoint_idx = keypoint_idx,
           .tile_idx = neighbor.tile_idx,
           .landmark_idx = neighbor.landmark_idx,
           .x_in_anchor =
               view.anchor_from_tile * tile.x_in_tile[neighbor.landmark_idx].cast<double>(),
           .sq_distance = neighbor.sq_distance,
           .sigma_m = static_cast<float>(SigmaFromCode(tile.sigma_codes[neighbor.landmark_idx])),
           .azimuth_rad =
               static_cast<float>(AzimuthFromCode(tile.azimuth_codes[neighbor.descriptor_idx])),
           .size_m = static_cast<float>(SizeFromCode(tile.size_codes[neighbor.descriptor_idx]))});
    }
  }
  return correspondences;
}

int64_t LandmarkRanking::NumMatchedKeypoints() const {
  return static_cast<int64_t>(std::count_if(num_neighbors_.begin(), num_neighbors_.end(),
                                            [](int count) { return count > 0; }));
}

}  // namespace cairn
