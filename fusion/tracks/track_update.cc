#include "fusion/tracks/track_update.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/require.h"
#include "fusion/filter/chi_square.h"

namespace cairn::fusion {
namespace {

// All columns that tracks touch: the shared blocks, then every clone.
std::vector<StateBlock> TrackColumns(const FilterState& state, std::span<const TrackRows> tracks) {
  std::vector<StateBlock> blocks;
  for (const TrackRows& track : tracks) {
    for (const StateBlock& block : track.clones.blocks) {
      if (block.offset < state.CloneIdx(0) &&
          std::find(blocks.begin(), blocks.end(), block) == blocks.end()) {
        blocks.push_back(block);
      }
    }
  }
  blocks.push_back({state.CloneIdx(0), state.dim() - state.CloneIdx(0)});
  return blocks;
}

// Writes a track's rows into the columns that TrackColumns lists.
void Append(const Measurement& track, Eigen::Index row, Measurement* stacked) {
  Eigen::Index column = 0;
  for (const StateBlock& block : track.blocks) {
    Eigen::Index target = 0;
    for (const StateBlock& other : stacked->blocks) {
      if (block.offset >= other.offset && block.offset < other.offset + other.size) {
        target += block.offset - other.offset;
        break;
      }
      target += other.size;
    }
    stacked->jacobian.block(row, target, track.num_rows(), block.size) =
        track.jacobian.middleCols(column, block.size);
    column += block.size;
  }
  stacked->residual.segment(row, track.num_rows()) = track.residual;
}

// The map's knowledge of a track's point, expressed at the current state.
struct DistanceRow {
  PlanePrior prior;
  Eigen::Vector3d direction_in_global;
  std::vector<StateBlock> blocks;  // global_from_local; the tile if the state has tiles.
  int num_dims = 0;                // Total size of the blocks.
};

std::optional<DistanceRow> MakeDistanceRow(const FilterState& state,
                                           const std::optional<MapDistance>& distance) {
  if (!distance || !state.global_from_local()) {
    return std::nullopt;
  }
  const Rigid3d local_from_global = state.global_from_local()->Inverse();
  DistanceRow row{{local_from_global * distance->x_in_global,
                   local_from_global.rotation * distance->direction_in_global, distance->sigma_m},
                  distance->direction_in_global,
                  {{kGlobalIdx, kGlobalDim}},
                  kGlobalDim};
  if (state.has_tiles()) {
    const auto tile_idx = state.FindTileIdx(distance->tile_id);
    if (!tile_idx) {
      return std::nullopt;
    }
    row.blocks.push_back({*tile_idx, kTileDim});
    row.num_dims += kTileDim;
  }
  return row;
}

// Fills `row` for a point at `x_in_local`. Columns: the point first, those of `distance` from
// `begin` on, the residual last.
void WriteDistanceRow(const DistanceRow& distance, const Eigen::Vector3d& x_in_local,
                      Eigen::Index begin,
                      Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> row) {
  const Eigen::RowVector3d normal = distance.prior.normal_in_local.transpose();
  const Eigen::RowVector3d by_rotation = -normal * Skew(x_in_local);
  row.setZero();
  row.head<3>() = normal;
  row.segment<kGlobalDim>(begin) << normal, by_rotation.z(), by_rotation.head<2>();
  if (distance.num_dims > kGlobalDim) {
    row.segment<kTileDim>(begin + kGlobalDim) = -distance.direction_in_global.transpose();
  }
  row[row.size() - 1] = normal.dot(distance.prior.x_in_local - x_in_local);
  row /= distance.prior.sigma_m;
}

// Largest standard deviation of the distance of a point that enters the state, relative to the
// distance and including the errors of the poses. Above this limit the filter is overconfident
// (docs/math/fusion.md).
constexpr double kMaxRelativePointSigma = 0.06;

// Returns true if the baseline between the first and the last observation is known well enough to
// triangulate on. If the baseline is a guess, the triangulated point is a guess, too. Without this
// limit, a device that only turned, but whose IMU suggested motion, became too sure of that motion.
bool HasBaseline(const FilterState& state, std::span<const Observation> observations) {
  constexpr double kMaxRelativeSigma = 0.5;  // Relative to the baseline.
  const int first = FindClone(state, observations.front().frame_id);
  const int last = FindClone(state, observations.back().frame_id);
  const double length_m = (state.clones()[static_cast<size_t>(last)].local_from_imu.translation -
                           state.clones()[static_cast<size_t>(first)].local_from_imu.translation)
                              .norm();
  const auto covariance = state.covariance();
  double variance = 0.0;
  for (int axis = 3; axis < 6; ++axis) {
    const int a = state.CloneIdx(first) + axis;
    const int b = state.CloneIdx(last) + axis;
    variance += covariance(a, a) + covariance(b, b) - 2.0 * covariance(a, b);
  }
  return std::sqrt(std::max(variance, 0.0)) < kMaxRelativeSigma * length_m;
}

// Returns true if the pixels, and the map if it was asked, tell the distance of the point from the
// newest clone well enough. Assumes that the poses are exact.
bool PixelsTellDistance(const PointRows& point, const FilterState& state) {
  const Eigen::Vector3d view = point.x_in_local - state.clones().back().local_from_imu.translation;
  // Standard deviation along the viewing ray, times the distance.
  const double sigma = point.by_point.transpose().triangularView<Eigen::Lower>().solve(view).norm();
  return sigma < kMaxRelativePointSigma * view.squaredNorm();
}

// Returns true if the state knows the distance of the point well enough, including the errors of
// the poses. Future observations are then nearly linear in the point.
bool IsDistanceKnown(const FilterState& state, int slot) {
  const int idx = state.PointIdx(slot) + 2;
  const double inverse_distance = state.points()[static_cast<size_t>(slot)]->coordinates.z();
  return std::sqrt(state.covariance()(idx, idx)) < kMaxRelativePointSigma * inverse_distance;
}

// Adds the points of tracks that go on to the state where slots are free. Call after the update
// with these tracks: the points' first estimates, at which their derivatives stay, then use the
// best poses available. The rows of the points themselves are still unused.
void EnterPoints(const Camera& camera, const std::vector<const FinishedTrack*>& tracks,
                 const TrackUpdateOptions& options, FilterState* state) {
  const std::vector<CameraView> views = ViewsOfClones(*state);
  const int num_slots = static_cast<int>(state->points().size());
  int slot = 0;
  for (const FinishedTrack* track : tracks) {
    while (slot < num_slots && state->points()[static_cast<size_t>(slot)]) {
      ++slot;
    }
    if (slot == num_slots) {
      return;
    }
    const auto rows = track->goes_on ? LinearizeTrack(*state, camera, views, track->observations,
                                                      options, track->map_distance)
                                     : std::nullopt;
    if (rows && PixelsTellDistance(rows->point, *state) &&
        state->EnterPoint(slot, track->track_id, rows->point) && !IsDistanceKnown(*state, slot)) {
      state->RemovePoint(slot);
    }
  }
}

}  // namespace

void TrackUpdateOptions::Validate() const {
  triangulate.Validate();
  RequireOption(sigma_px > 0.0, "tracks.sigma_px must be positive");
  RequireOption(max_tracks >= 1, "tracks.max_tracks must be at least 1");
}

std::vector<CameraView> ViewsOfClones(const FilterState& state) {
  std::vector<CameraView> views;
  views.reserve(state.clones().size());
  for (const Clone& clone : state.clones()) {
    views.emplace_back(state.rig(), clone);
  }
  return views;
}

int FindClone(const FilterState& state, int64_t frame_id) {
  const auto& clones = state.clones();
  const auto found =
      std::lower_bound(clones.begin(), clones.end(), frame_id,
                       [](const Clone& clone, int64_t wanted) { return clone.frame_id < wanted; });
  return found != clones.end() && found->frame_id == frame_id
             ? static_cast<int>(found - clones.begin())
             : -1;
}

std::optional<TrackRows> LinearizeTrack(const FilterState& state, const Camera& camera,
                                        std::span<const CameraView> views,
                                        std::span<const Observation> observations,
                                        const TrackUpdateOptions& options,
                                        const std::optional<MapDistance>& map_distance) {
  std::vector<PosedObservation> posed;
  std::vector<StateBlock> blocks;
  for (const Observation& observation : observations) {
    const int clone = FindClone(state, observation.frame_id);
    CAIRN_CHECK(clone >= 0, "observations are at clones");
    posed.push_back(
        {&views[static_cast<size_t>(clone)], observation.pixel, observation.ray_in_cam});
    blocks.push_back({state.CloneIdx(clone), kCloneDim});
  }
  const std::optional<DistanceRow> distance = MakeDistanceRow(state, map_distance);
  const auto x_in_local = Triangulate(camera, posed, options.sigma_px, options.triangulate,
                                      distance ? std::optional(distance->prior) : std::nullopt);
  if (!x_in_local) {
    return std::nullopt;
  }
  // Columns: the point, the clones in turn, the rig, the blocks of the distance, the residual.
  const int num_views = static_cast<int>(posed.size());
  const int rig_begin = 3 + kCloneDim * num_views;
  const int distance_begin = rig_begin + (state.estimates_rig() ? kRigDim : 0);
  const int width = distance_begin + (distance ? distance->num_dims : 0);
  const int num_rows = 2 * num_views + (distance ? 1 : 0);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(num_rows, width + 1);
  for (int i = 0; i < num_views; ++i) {
    const PosedObservation& observation = posed[static_cast<size_t>(i)];
    const auto predicted = PredictPixel(camera, *observation.view, *x_in_local);
    if (!predicted) {
      return std::nullopt;
    }
    rows.block<2, 3>(2 * i, 0) = predicted->by_local;
    rows.block<2, kCloneDim>(2 * i, 3 + kCloneDim * i) =
        ByClone(*predicted, *observation.view, *x_in_local);
    if (state.estimates_rig()) {
      rows.block<2, kRigDim>(2 * i, rig_begin) = ByRig(*predicted, state.rig());
    }
    rows.block<2, 1>(2 * i, width) = observation.pixel - predicted->pixel;
  }
  rows.topRows(2 * num_views) /= options.sigma_px;
  if (state.estimates_rig()) {
    blocks.push_back({kRigIdx, kRigDim});
  }
  if (distance) {
    WriteDistanceRow(*distance, *x_in_local, distance_begin, rows.row(num_rows - 1));
    blocks.insert(blocks.end(), distance->blocks.begin(), distance->blocks.end());
  }
  Triangularize(3, rows);
  return TrackRows{
      {blocks, rows.block(3, 3, num_rows - 3, width - 3), rows.col(width).tail(num_rows - 3)},
      {*x_in_local,
       rows.topLeftCorner<3, 3>(),
       {blocks, rows.block(0, 3, 3, width - 3), rows.col(width).head<3>()}}};
}

Measurement StackTracks(const FilterState& state, std::span<const TrackRows> tracks) {
  Eigen::Index num_rows = 0;
  for (const TrackRows& track : tracks) {
    num_rows += track.clones.num_rows();
  }
  Measurement stacked;
  stacked.blocks = TrackColumns(state, tracks);
  Eigen::Index width = 0;
  for (const StateBlock& block : stacked.blocks) {
    width += block.size;
  }
  stacked.jacobian = Eigen::MatrixXd::Zero(num_rows, width);
  stacked.residual.resize(num_rows);
  Eigen::Index row = 0;
  for (const TrackRows& track : tracks) {
    Append(track.clones, row, &stacked);
    row += track.clones.num_rows();
  }
  Compress(&stacked);
  return stacked;
}

TrackUpdateCounts UpdateFromTracks(const Camera& camera, std::vector<FinishedTrack> tracks,
                                   const TrackUpdateOptions& options, FilterState* state) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const auto& a, const auto& b) {
    return a.observations.size() > b.observations.size();
  });
  TrackUpdateCounts counts;
  const std::vector<CameraView> views = ViewsOfClones(*state);
  const auto linearize_here = [&](const FinishedTrack& track) {
    return LinearizeTrack(*state, camera, views, track.observations, options, track.map_distance);
  };
  const auto passes = [&](const TrackRows& rows) {
    return state->SquaredMahalanobis(rows.clones) <
           ChiSquareQuantile(rows.clones.num_rows(), kTrackGateQuantile);
  };
  std::vector<TrackRows> accepted;
  std::vector<const FinishedTrack*> accepted_tracks;
  for (FinishedTrack& track : tracks) {
    if (static_cast<int>(accepted.size()) == options.max_tracks) {
      break;
    }
    const bool has_baseline = HasBaseline(*state, track.observations);
    auto rows = has_baseline ? linearize_here(track) : std::nullopt;
    bool fits = rows && passes(*rows);
    if (!fits && has_baseline && track.map_distance) {
      track.map_distance.reset();  // The map may be wrong although the observations are right.
      rows = linearize_here(track);
      fits = rows && passes(*rows);
    }
    if (!rows) {
      ++counts.num_not_triangulated;
    } else if (!fits) {
      ++counts.num_gated;
    } else {
      accepted.push_back(std::move(*rows));
      accepted_tracks.push_back(&track);
    }
  }
  if (accepted.empty()) {
    return counts;
  }
  counts.num_used = static_cast<int>(accepted.size());
  bool linearized = true;  // `accepted` is linearized at the present state.
  const auto linearize = [&](const FilterState& at) {
    if (!std::exchange(linearized, false)) {
      accepted.clear();
      const std::vector<CameraView> moved_views = ViewsOfClones(at);
      for (const FinishedTrack* track : accepted_tracks) {
        if (auto rows = LinearizeTrack(at, camera, moved_views, track->observations, options,
                                       track->map_distance)) {
          accepted.push_back(std::move(*rows));
        }
      }
    }
    return StackTracks(at, accepted);
  };
  state->IteratedUpdate(linearize);
  EnterPoints(camera, accepted_tracks, options, state);
  return counts;
}

}  // namespace cairn::fusion
