#include "engine/matching/landmark_ranking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
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

}  // namespace

LandmarkRanking::LandmarkRanking(const QueryContext& query, const Codebook& codebook,
                                 const MatchingOptions& options)
    : query_(query),
      options_(options),
      keypoint_directions_(query.num_keypoints(), Eigen::Vector2f::Zero()),
      neighbors_(size_t{1} * query.num_keypoints() * options.max_neighbors),
      num_neighbors_(query.num_keypoints(), 0),
      max_useful_sq_distances_(query.num_keypoints(), std::numeric_limits<float>::infinity()) {
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

double LandmarkRanking::MaxUsefulDistance(uint32_t keypoint_idx) const {
  // Distances are rounded to floats, of which the next one still counts.
  constexpr double kRounding = 1.0 + 1e-6;
  return kRounding * std::sqrt(static_cast<double>(MaxUsefulSqDistance(keypoint_idx)));
}

bool LandmarkRanking::IsCloser(const Neighbor& a, const Neighbor& b) {
  return std::tie(a.sq_distance, a.landmark_id, a.tile_idx, a.descriptor_idx) <
         std::tie(b.sq_distance, b.landmark_id, b.tile_idx, b.descriptor_idx);
}

float LandmarkRanking::SqOrientationChord(uint32_t keypoint_idx, uint8_t orientation_code) const {
  const Eigen::Vector2f& a = keypoint_directions_[keypoint_idx];
  const Eigen::Vector2f& b = CodeDirections()[orientation_code];
  if (a.isZero(0.0f) || b.isZero(0.0f)) {
    return 0.0f;
  }
  return (a - b).squaredNorm();
}

float LandmarkRanking::SqPositionExcess(const Eigen::Vector2f& x_from_prior) const {
  const auto viewing_distance_m = static_cast<float>(options_.viewing_distance_m);
  const float sq_distance = x_from_prior.squaredNorm();
  if (sq_distance <= viewing_distance_m * viewing_distance_m) {
    return 0.0f;
  }
  const float excess = (std::sqrt(sq_distance) - viewing_distance_m) /
                       static_cast<float>(query_.region.prior_sigma_m);
  return excess * excess;
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
  if (count == options_.max_neighbors) {
    max_useful_sq_distances_[keypoint_idx] = row.back().sq_distance;
  }
}

LandmarkRanking::TileHits::TileHits(LandmarkRanking* ranking, const TileView& view, int tile_idx,
                                    uint32_t first_keypoint)
    : ranking_(*ranking),
      view_(view),
      tile_(view.tile->tile()),
      tile_idx_(tile_idx),
      first_keypoint_(first_keypoint) {
  const Rigid3d& anchor_from_tile = view.anchor_from_tile;
  prior_from_tile_ = anchor_from_tile.rotation.toRotationMatrix().topRows<2>().cast<float>();
  tile_in_prior_ =
      (anchor_from_tile.translation.head<2>() - ranking->query_.region.prior_xy_in_anchor)
          .cast<float>();
}

float LandmarkRanking::TileHits::Take(const DescriptorHit& hit) {
  const uint32_t keypoint_idx = first_keypoint_ + hit.query_idx;
  const float max_sq_distance = ranking_.MaxUsefulSqDistance(keypoint_idx);
  if (hit.sq_distance <= max_sq_distance) {  // Prior terms only add.
    __builtin_prefetch(&tile_.orientation_codes[hit.descriptor_idx]);
    __builtin_prefetch(&view_.tile->landmark_of_descriptor()[hit.descriptor_idx]);
    DescriptorHit& place = hits_[num_hits_ % kAhead];
    if (num_hits_ >= kAhead) {
      Weigh(place);
    }
    place = {keypoint_idx, hit.descriptor_idx, hit.sq_distance};
    ++num_hits_;
  }
  return max_sq_distance;
}

void LandmarkRanking::TileHits::Weigh(const DescriptorHit& hit) {
  const float sq_chord =
      ranking_.SqOrientationChord(hit.query_idx, tile_.orientation_codes[hit.descriptor_idx]);
  const float sq_distance = hit.sq_distance + ranking_.orientation_factor_ * sq_chord;
  if (sq_chord > ranking_.max_sq_chord_ ||
      sq_distance > ranking_.MaxUsefulSqDistance(hit.query_idx)) {
    return;
  }
  const uint32_t landmark_idx = view_.tile->landmark_of_descriptor()[hit.descriptor_idx];
  __builtin_prefetch(&tile_.landmark_ids[landmark_idx]);
  __builtin_prefetch(&tile_.x_in_tile[landmark_idx]);
  Candidate& place = candidates_[num_candidates_ % kAhead];
  if (num_candidates_ >= kAhead) {
    Rank(&place);
  }
  place = {hit.query_idx, {sq_distance, tile_idx_, landmark_idx, hit.descriptor_idx, {}}};
  ++num_candidates_;
}

void LandmarkRanking::TileHits::Rank(Candidate* candidate) {
  Neighbor& neighbor = candidate->neighbor;
  neighbor.landmark_id = tile_.landmark_ids[neighbor.landmark_idx];
  if (ranking_.uses_position_) {
    const float sq_excess = ranking_.SqPositionExcess(
        prior_from_tile_ * tile_.x_in_tile[neighbor.landmark_idx] + tile_in_prior_);
    if (sq_excess > ranking_.max_sq_excess_) {
      return;
    }
    neighbor.sq_distance += ranking_.position_factor_ * sq_excess;
  }
  ranking_.Insert(candidate->keypoint_idx, neighbor);
}

void LandmarkRanking::TileHits::Flush() {
  for (size_t i = num_hits_ - std::min(num_hits_, kAhead); i < num_hits_; ++i) {
    Weigh(hits_[i % kAhead]);
  }
  for (size_t i = num_candidates_ - std::min(num_candidates_, kAhead); i < num_candidates_; ++i) {
    Rank(&candidates_[i % kAhead]);
  }
  num_hits_ = 0;
  num_candidates_ = 0;
}

void LandmarkRanking::PrefetchNeighbors(int keypoint_idx,
                                        const std::vector<TileView>& tiles) const {
  for (int i = 0; i < num_neighbors_[keypoint_idx]; ++i) {
    const Neighbor& neighbor = neighbors_[size_t{1} * keypoint_idx * options_.max_neighbors + i];
    const Tile& tile = tiles[neighbor.tile_idx].tile->tile();
    __builtin_prefetch(&tile.x_in_tile[neighbor.landmark_idx]);
    __builtin_prefetch(&tile.sigma_codes[neighbor.landmark_idx]);
    __builtin_prefetch(&tile.azimuth_codes[neighbor.descriptor_idx]);
    __builtin_prefetch(&tile.size_codes[neighbor.descriptor_idx]);
  }
}

std::vector<Correspondence> LandmarkRanking::Correspondences(
    const std::vector<TileView>& tiles) const {
  constexpr int kAhead = 4;  // Keypoints whose landmarks are asked for ahead.
  std::vector<Correspondence> correspondences;
  correspondences.reserve(std::accumulate(num_neighbors_.begin(), num_neighbors_.end(), size_t{0}));
  for (int keypoint_idx = 0; keypoint_idx < query_.num_keypoints(); ++keypoint_idx) {
    if (keypoint_idx + kAhead < query_.num_keypoints()) {
      PrefetchNeighbors(keypoint_idx + kAhead, tiles);
    }
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
