#include "engine/matching/landmark_ranking.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

#include "core/angles.h"
#include "core/random.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// Chords are rounded; the tolerance lets a difference of exactly the bound pass the hard filter.
constexpr float kChordTolerance = 1e-5f;

std::optional<float> OrientationOf(uint8_t code) {
  return code == kNoOrientation ? std::nullopt
                                : std::optional(static_cast<float>(OrientationFromCode(code)));
}

}  // namespace

const std::array<LandmarkRanking::Direction, 256>& LandmarkRanking::CodeDirections() {
  static const std::array<Direction, 256> directions = [] {
    std::array<Direction, 256> made;
    for (int code = 0; code < kNoOrientation; ++code) {
      const double angle_rad = OrientationFromCode(static_cast<uint8_t>(code));
      made[code] = {static_cast<float>(std::cos(angle_rad)),
                    static_cast<float>(std::sin(angle_rad)), 1.0f};
    }
    return made;
  }();
  return directions;
}

LandmarkRanking::LandmarkRanking(const QueryContext& query, const Codebook& codebook,
                                 const MatchingOptions& options, std::span<const int> order)
    : query_(query),
      options_(options),
      order_(order),
      keypoint_directions_(query.num_keypoints()),
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
  if (options.max_orientation_difference_rad < kPi) {
    max_sq_chord_ =
        static_cast<float>(2.0 - 2.0 * std::cos(options.max_orientation_difference_rad)) +
        kChordTolerance;
  }
  for (int i = 0; i < query.num_keypoints(); ++i) {
    if (const std::optional<float> angle_rad = query.gravity_orientations_rad[KeypointAt(i)]) {
      keypoint_directions_[i] = {std::cos(*angle_rad), std::sin(*angle_rad), 1.0f};
    }
  }
}

double LandmarkRanking::MaxUsefulDistance(uint32_t rank) const {
  // Distances are rounded to floats; a hit one rounding step beyond still counts.
  constexpr double kRounding = 1.0 + 1e-6;
  return kRounding * std::sqrt(static_cast<double>(MaxUsefulSqDistance(rank)));
}

bool LandmarkRanking::IsCloser(const Neighbor& a, const Neighbor& b) {
  return std::tie(a.sq_distance, a.landmark_id, a.tile_idx, a.descriptor_idx) <
         std::tie(b.sq_distance, b.landmark_id, b.tile_idx, b.descriptor_idx);
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

void LandmarkRanking::Insert(uint32_t rank, const Neighbor& neighbor) {
  const std::span<Neighbor> row(neighbors_.data() + size_t{rank} * options_.max_neighbors,
                                options_.max_neighbors);
  int& count = num_neighbors_[rank];
  // The neighbor replaces the entry of its landmark, else takes a free entry, else replaces the
  // last.
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
    max_useful_sq_distances_[rank] = row.back().sq_distance;
  }
}

LandmarkRanking::TileHits::TileHits(LandmarkRanking* ranking, const TileView& view,
                                    const DescriptorPlaces& places, int tile_idx,
                                    uint32_t first_rank)
    : ranking_(*ranking),
      tile_(view.tile->landmarks()),
      places_(places),
      tile_idx_(tile_idx),
      first_rank_(first_rank) {
  const Rigid3d& anchor_from_tile = view.anchor_from_tile;
  prior_from_tile_ = anchor_from_tile.rotation.toRotationMatrix().topRows<2>().cast<float>();
  tile_in_prior_ =
      (anchor_from_tile.translation.head<2>() - ranking->query_.region.prior_xy_in_anchor)
          .cast<float>();
  const CoarseGrid& grid = places.grid();
  prior_from_coarse_ = grid.step_m() * prior_from_tile_.leftCols<2>();
  coarse_in_prior_ = prior_from_tile_.leftCols<2>() * grid.corner() + tile_in_prior_;
  // The error is half a diagonal of the grid, the effect of the height where the verticals of the
  // two frames differ, and rounding.
  constexpr float kRounding = 1e-5f;
  const float coarse_error_m = grid.step_m() +
                               prior_from_tile_.col(2).norm() * grid.max_height_m() +
                               kRounding * (1.0f + tile_in_prior_.norm() + grid.corner().norm());
  max_free_m_ = static_cast<float>(ranking->options_.viewing_distance_m) + coarse_error_m;
  if (ranking->position_factor_ > 0.0f) {
    per_sigma_ = 1.0f / static_cast<float>(ranking->query_.region.prior_sigma_m);
  }
}

float LandmarkRanking::TileHits::Take(const HitRun& run) {
  TakeLast();
  const uint32_t rank = first_rank_ + run.query_idx;
  last_.resize(std::max(last_.size(), run.hits.size()));
  num_last_ = run.hits.size();
  for (size_t i = 0; i < num_last_; ++i) {
    places_.Prefetch(run.hits[i].row);
    last_[i] = {rank, run.hits[i].row, run.SqDistance(i)};
  }
  return ranking_.MaxUsefulSqDistance(rank);
}

void LandmarkRanking::TileHits::TakeLast() {
  const size_t num_kept = num_last_ > 0 ? Keep() : 0;
  for (size_t i = 0; i < num_kept; ++i) {
    QueueHit(last_[i]);
  }
  num_last_ = 0;
}

size_t LandmarkRanking::TileHits::Keep() {
  // The lower bound of the position term comes from coarser numbers; rounding must not make it
  // larger than the term.
  constexpr float kRounding = 1.0f + 1e-5f;
  const uint32_t rank = last_.front().rank;
  const float max_sq_distance = kRounding * ranking_.MaxUsefulSqDistance(rank);
  const Direction direction = ranking_.keypoint_directions_[rank];
  const std::array<Direction, 256>& code_directions = CodeDirections();
  size_t num_kept = 0;
  for (size_t i = 0; i < num_last_; ++i) {
    Hit hit = last_[i];
    const float sq_chord = SqChord(direction, code_directions[places_.orientation_code(hit.place)]);
    hit.sq_distance += ranking_.orientation_factor_ * sq_chord;
    const float from_prior_m =
        (prior_from_coarse_ * places_.CoarseXy(hit.place) + coarse_in_prior_).norm();
    const float excess = std::max(0.0f, from_prior_m - max_free_m_) * per_sigma_;
    const bool is_kept =
        (sq_chord <= ranking_.max_sq_chord_) &
        (hit.sq_distance + ranking_.position_factor_ * excess * excess <= max_sq_distance);
    last_[num_kept] = hit;
    num_kept += is_kept ? 1 : 0;  // Avoids a branch, which would be mispredicted.
  }
  return num_kept;
}

void LandmarkRanking::TileHits::QueueHit(const Hit& hit) {
  places_.PrefetchLandmark(hit.place);
  Hit& place = hits_[num_hits_ % kAhead];
  if (num_hits_ >= kAhead) {
    QueueCandidate(place);
  }
  place = hit;
  ++num_hits_;
}

void LandmarkRanking::TileHits::QueueCandidate(const Hit& hit) {
  if (hit.sq_distance > ranking_.MaxUsefulSqDistance(hit.rank)) {
    return;
  }
  const uint32_t landmark_idx = places_.landmark(hit.place);
  __builtin_prefetch(&tile_.landmark_ids[landmark_idx]);
  __builtin_prefetch(&tile_.x_in_tile[landmark_idx]);
  Candidate& place = candidates_[num_candidates_ % kAhead];
  if (num_candidates_ >= kAhead) {
    Rank(&place);
  }
  place = {hit.rank, {hit.sq_distance, tile_idx_, landmark_idx, places_.descriptor(hit.place), {}}};
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
  ranking_.Insert(candidate->rank, neighbor);
}

void LandmarkRanking::TileHits::Flush() {
  TakeLast();
  for (size_t i = num_hits_ - std::min(num_hits_, kAhead); i < num_hits_; ++i) {
    QueueCandidate(hits_[i % kAhead]);
  }
  for (size_t i = num_candidates_ - std::min(num_candidates_, kAhead); i < num_candidates_; ++i) {
    Rank(&candidates_[i % kAhead]);
  }
  num_hits_ = 0;
  num_candidates_ = 0;
}

void LandmarkRanking::PrefetchNeighbors(int rank, const std::vector<TileView>& tiles) const {
  for (int i = 0; i < num_neighbors_[rank]; ++i) {
    const Neighbor& neighbor = neighbors_[size_t{1} * rank * options_.max_neighbors + i];
    const TileLandmarks& tile = tiles[neighbor.tile_idx].tile->landmarks();
    __builtin_prefetch(&tile.x_in_tile[neighbor.landmark_idx]);
    __builtin_prefetch(&tile.sigma_codes[neighbor.landmark_idx]);
    __builtin_prefetch(&tile.azimuth_codes[neighbor.descriptor_idx]);
    __builtin_prefetch(&tile.size_codes[neighbor.descriptor_idx]);
    __builtin_prefetch(&tile.orientation_codes[neighbor.descriptor_idx]);
  }
}

float LandmarkRanking::DescriptorSqDistance(int rank, const Neighbor& neighbor,
                                            const TileView& view) const {
  const TileLandmarks& tile = view.tile->landmarks();
  float sq_distance =
      neighbor.sq_distance -
      orientation_factor_ *
          SqChord(keypoint_directions_[rank],
                  CodeDirections()[tile.orientation_codes[neighbor.descriptor_idx]]);
  if (uses_position_) {
    const Eigen::Vector3d x_in_anchor =
        view.anchor_from_tile * tile.x_in_tile[neighbor.landmark_idx].cast<double>();
    sq_distance -=
        position_factor_ *
        SqPositionExcess((x_in_anchor.head<2>() - query_.region.prior_xy_in_anchor).cast<float>());
  }
  return std::max(0.0f, sq_distance);
}

Correspondence LandmarkRanking::MakeCorrespondence(int rank, const Neighbor& neighbor,
                                                   const TileView& view) const {
  const TileLandmarks& tile = view.tile->landmarks();
  return {
      .keypoint_idx = KeypointAt(rank),
      .tile_idx = neighbor.tile_idx,
      .landmark_idx = neighbor.landmark_idx,
      .x_in_anchor = view.anchor_from_tile * tile.x_in_tile[neighbor.landmark_idx].cast<double>(),
      .sq_distance = neighbor.sq_distance,
      .sigma_m = static_cast<float>(SigmaFromCode(tile.sigma_codes[neighbor.landmark_idx])),
      .azimuth_rad =
          static_cast<float>(AzimuthFromCode(tile.azimuth_codes[neighbor.descriptor_idx])),
      .size_m = static_cast<float>(SizeFromCode(tile.size_codes[neighbor.descriptor_idx])),
      .descriptor_sq_distance = DescriptorSqDistance(rank, neighbor, view),
      .orientation_rad = OrientationOf(tile.orientation_codes[neighbor.descriptor_idx])};
}

std::vector<bool> LandmarkRanking::FindSurplus() const {
  // A landmark whose hash counts few keypoints has few. Most landmarks of a map of a city have one.
  std::vector<int> num_by_hash(std::bit_ceil(neighbors_.size() + 1), 0);
  const auto num_of = [&](LandmarkId id) -> int& {
    return num_by_hash[(static_cast<uint64_t>(id) * kSplitMixStep >> 32) &
                       (num_by_hash.size() - 1)];
  };
  ForEachNeighbor([&](int, size_t idx) { ++num_of(neighbors_[idx].landmark_id); });
  // Neighbors in the order in which each landmark takes them.
  std::vector<std::tuple<LandmarkId, float, int, size_t>> uses;
  ForEachNeighbor([&](int rank, size_t idx) {
    const Neighbor& neighbor = neighbors_[idx];
    if (num_of(neighbor.landmark_id) > options_.max_keypoints_of_landmark) {
      uses.emplace_back(neighbor.landmark_id, neighbor.sq_distance, KeypointAt(rank), idx);
    }
  });
  std::sort(uses.begin(), uses.end());
  std::vector<bool> is_surplus(neighbors_.size(), false);
  int num_nearer = 0;
  for (size_t i = 0; i < uses.size(); ++i) {
    num_nearer = i > 0 && std::get<0>(uses[i]) == std::get<0>(uses[i - 1]) ? num_nearer + 1 : 0;
    is_surplus[std::get<size_t>(uses[i])] = num_nearer >= options_.max_keypoints_of_landmark;
  }
  return is_surplus;
}

std::vector<Correspondence> LandmarkRanking::Correspondences(
    const std::vector<TileView>& tiles) const {
  constexpr int kAhead = 4;  // Number of keypoints ahead whose landmarks are prefetched.
  std::vector<int> ranks;    // In order of keypoint.
  if (!order_.empty()) {
    ranks.resize(order_.size());
    for (size_t rank = 0; rank < order_.size(); ++rank) {
      ranks[order_[rank]] = static_cast<int>(rank);
    }
  }
  const auto rank_of = [&](int keypoint_idx) {
    return ranks.empty() ? keypoint_idx : ranks[keypoint_idx];
  };
  const std::vector<bool> is_surplus = FindSurplus();
  std::vector<Correspondence> correspondences;
  correspondences.reserve(std::accumulate(num_neighbors_.begin(), num_neighbors_.end(), size_t{0}));
  for (int keypoint_idx = 0; keypoint_idx < query_.num_keypoints(); ++keypoint_idx) {
    if (keypoint_idx + kAhead < query_.num_keypoints()) {
      PrefetchNeighbors(rank_of(keypoint_idx + kAhead), tiles);
    }
    const int rank = rank_of(keypoint_idx);
    for (int i = 0; i < num_neighbors_[rank]; ++i) {
      const size_t idx = size_t{1} * rank * options_.max_neighbors + i;
      if (!is_surplus[idx]) {
        const Neighbor& neighbor = neighbors_[idx];
        correspondences.push_back(MakeCorrespondence(rank, neighbor, tiles[neighbor.tile_idx]));
      }
    }
  }
  return correspondences;
}

}  // namespace cairn
