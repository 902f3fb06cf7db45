#include "engine/places/place_votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/angles.h"
#include "storage/tile/tile.h"

namespace cairn {
namespace {

// A cell of a zone: the tile's indices times PlaceCells::kPerSide plus the cell's.
struct WorldCell {
  int zone = 0;  // Negative in the south.
  int x = 0, y = 0;

  bool operator==(const WorldCell&) const = default;
  bool operator<(const WorldCell& other) const {
    return std::tie(zone, y, x) < std::tie(other.zone, other.y, other.x);
  }
};

struct HashOfWorldCell {
  size_t operator()(const WorldCell& cell) const {
    constexpr uint64_t kOdd = 0x9E3779B97F4A7C15;  // 2^64 over the golden ratio.
    const uint64_t packed = static_cast<uint64_t>(cell.zone) * 0x100000001B3 ^
                            static_cast<uint64_t>(static_cast<uint32_t>(cell.y)) << 32 ^
                            static_cast<uint32_t>(cell.x);
    return packed * kOdd >> 16;
  }
};

WorldCell CellOf(TileId tile, uint8_t cell) {
  return {tile.north() ? tile.zone() : -1 - tile.zone(),
          tile.easting_idx() * PlaceCells::kPerSide + cell % PlaceCells::kPerSide,
          tile.northing_idx() * PlaceCells::kPerSide + cell / PlaceCells::kPerSide};
}

bool AreNear(const WorldCell& a, const WorldCell& b, int max_cells) {
  return a.zone == b.zone && std::abs(a.x - b.x) <= max_cells && std::abs(a.y - b.y) <= max_cells;
}

// A photo and a keyframe that share what they see differ in the direction to a landmark by less
// than 45 degrees: three headings of 30 degrees.
constexpr int kNumHeadings = 12, kHeadingsOfWindow = 3;

struct CellVotes {
  std::array<double, kNumHeadings> by_heading{};
  double sum = 0.0;  // Of all headings.
  TileId tile;
  uint8_t cell_of_tile = 0;
};

using VotesByCell = std::unordered_map<WorldCell, CellVotes, HashOfWorldCell>;

// Returns true if one window of headings may hold both.
bool AreSimilar(int heading, int other) {
  const int difference = std::abs(heading - other);
  return std::min(difference, kNumHeadings - difference) < kHeadingsOfWindow;
}

// Returns the middle of a cell in ECEF, at height 0.
Eigen::Vector3d MiddleOfCell(const CellVotes& votes) {
  const auto coordinate_m = [](int place) {
    return (place + 0.5) * PlaceCells::kSideM - 0.5 * TileId::kSideM;
  };
  return EcefFromEnu(votes.tile.Anchor()) *
         Eigen::Vector3d(coordinate_m(votes.cell_of_tile % PlaceCells::kPerSide),
                         coordinate_m(votes.cell_of_tile / PlaceCells::kPerSide), 0.0);
}

// A cell with the votes of the cells around it.
struct Candidate {
  WorldCell cell;
  double score = 0.0;
  Eigen::Vector3d center_in_ecef = Eigen::Vector3d::Zero();  // Weighted by the votes.
};

std::vector<std::pair<double, WorldCell>> CellsByScore(const VotesByCell& votes) {
  std::vector<std::pair<double, WorldCell>> cells;
  for (const auto& [cell, of_cell] : votes) {
    std::array<double, kNumHeadings> by_heading{};
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto found = votes.find({cell.zone, cell.x + dx, cell.y + dy});
        for (int i = 0; found != votes.end() && i < kNumHeadings; ++i) {
          by_heading[i] += found->second.by_heading[i];
        }
      }
    }
    double score = 0.0;
    for (int i = 0; i < kNumHeadings; ++i) {
      double of_window = 0.0;
      for (int k = 0; k < kHeadingsOfWindow; ++k) {
        of_window += by_heading[(i + k) % kNumHeadings];
      }
      score = std::max(score, of_window);
    }
    cells.emplace_back(score, cell);
  }
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  return cells;
}

// Returns the mean of the cells around `cell`, weighted by their votes.
Eigen::Vector3d CenterInEcef(const VotesByCell& votes, const WorldCell& cell) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0.0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (const auto found = votes.find({cell.zone, cell.x + dx, cell.y + dy});
          found != votes.end()) {
        sum += found->second.sum * MiddleOfCell(found->second);
        weight += found->second.sum;
      }
    }
  }
  return weight > 0.0 ? Eigen::Vector3d(sum / weight) : MiddleOfCell(votes.at(cell));
}

}  // namespace

bool PlaceVotes::MayBeSame(uint32_t keypoint, uint8_t orientation_code) const {
  constexpr double kMaxDifferenceRad = 0.5;
  const std::optional<float>& orientation_rad = query_.gravity_orientations_rad[keypoint];
  return !orientation_rad || orientation_code == kNoOrientation ||
         std::abs(std::remainder(*orientation_rad - OrientationFromCode(orientation_code),
                                 2.0 * kPi)) < kMaxDifferenceRad;
}

int PlaceVotes::HeadingOf(size_t keypoint, uint8_t azimuth_code) const {
  if (!query_.level_from_cam) {
    return 0;
  }
  const Eigen::Vector3d ray_in_level = *query_.level_from_cam * query_.rays_in_cam[keypoint];
  const double yaw_rad =
      AzimuthFromCode(azimuth_code) + kPi - std::atan2(ray_in_level.y(), ray_in_level.x());
  const double turns = yaw_rad / (2.0 * kPi);
  return std::min(kNumHeadings - 1, static_cast<int>((turns - std::floor(turns)) * kNumHeadings));
}

PlaceVotes::PlaceVotes(const QueryContext& query, int max_neighbors, double max_distance)
    : query_(query),
      max_neighbors_(max_neighbors),
      max_sq_distance_(static_cast<float>(max_distance * max_distance)),
      neighbors_(static_cast<size_t>(query.num_keypoints()) * (max_neighbors + 1)) {}

float PlaceVotes::Take(const HitRun& run) {
  Neighbor* neighbors = NeighborsOf(run.query_idx);
  for (size_t i = 0; i < run.hits.size(); ++i) {
    const float sq_distance = run.SqDistance(i);
    if (!(sq_distance < neighbors[max_neighbors_].sq_distance) ||
        !MayBeSame(run.query_idx, segment_->TraitsAt(run.hits[i].row).orientation_code)) {
      continue;
    }
    int place = max_neighbors_;
    for (; place > 0 && sq_distance < neighbors[place - 1].sq_distance; --place) {
      neighbors[place] = neighbors[place - 1];
    }
    neighbors[place] = {sq_distance, run.hits[i].row, segment_};
  }
  return std::min(max_sq_distance_, neighbors[max_neighbors_].sq_distance);
}

std::vector<double> PlaceVotes::MaxDistances() const {
  std::vector<double> max_distances;
  for (size_t last = max_neighbors_; last < neighbors_.size(); last += max_neighbors_ + 1) {
    max_distances.push_back(std::sqrt(std::min(max_sq_distance_, neighbors_[last].sq_distance)));
  }
  return max_distances;
}

std::vector<RankedPlace> PlaceVotes::Best(int max_places, double min_separation_m) const {
  VotesByCell votes;
  const size_t row_size = static_cast<size_t>(max_neighbors_) + 1;
  std::vector<std::pair<WorldCell, int>> voted_for;
  for (size_t first = 0; first < neighbors_.size(); first += row_size) {
    const float sq_background =
        std::min(max_sq_distance_, neighbors_[first + max_neighbors_].sq_distance);
    voted_for.clear();
    for (size_t i = first; i < first + row_size; ++i) {
      const Neighbor& neighbor = neighbors_[i];
      if (!(neighbor.sq_distance < sq_background)) {
        break;
      }
      const TileId tile = neighbor.segment->TileAt(neighbor.row);
      const PlaceTraits& traits = neighbor.segment->TraitsAt(neighbor.row);
      const WorldCell cell = CellOf(tile, traits.cell);
      const int heading = HeadingOf(first / row_size, traits.azimuth_code);
      // Two cells around a third one would count the keypoint twice.
      if (std::any_of(voted_for.begin(), voted_for.end(), [&](const auto& other) {
            return AreNear(cell, other.first, 2) && AreSimilar(heading, other.second);
          })) {
        continue;
      }
      voted_for.emplace_back(cell, heading);
      CellVotes& of_cell = votes[cell];
      const double weight = (sq_background - neighbor.sq_distance) / max_sq_distance_;
      of_cell.sum += weight;
      of_cell.by_heading[heading] += weight;
      of_cell.tile = tile;
      of_cell.cell_of_tile = traits.cell;
    }
  }
  std::vector<RankedPlace> best;
  std::vector<Eigen::Vector3d> centers_in_ecef;
  for (const auto& [score, cell] : CellsByScore(votes)) {
    if (static_cast<int>(best.size()) == max_places) {
      break;
    }
    const Eigen::Vector3d center_in_ecef = CenterInEcef(votes, cell);
    const bool is_known = std::any_of(centers_in_ecef.begin(), centers_in_ecef.end(),
                                      [&](const Eigen::Vector3d& other) {
                                        return (other - center_in_ecef).norm() < min_separation_m;
                                      });
    if (!is_known) {
      centers_in_ecef.push_back(center_in_ecef);
      Geodetic center = GeodeticFromEcef(center_in_ecef);
      center.h_m = 0.0;
      best.push_back({center, score});
    }
  }
  return best;
}

}  // namespace cairn
