#include "fusion/track_update.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "fusion/chi_square.h"

namespace cairn::fusion {
namespace {

// All columns that tracks touch: the rig, if it is estimated, and every clone.
std::vector<StateBlock> TrackColumns(const FilterState& state) {
  std::vector<StateBlock> blocks;
  if (state.estimates_rig()) {
    blocks.push_back({kRigIdx, kRigDim});
  }
  blocks.push_back({state.CloneIdx(0), state.dim() - state.CloneIdx(0)});
  return blocks;
}

// Writes a track's rows into the columns of TrackColumns.
void Append(const FilterState& state, const Measurement& track, Eigen::Index row,
            Measurement* stacked) {
  const int rig_dims = state.estimates_rig() ? kRigDim : 0;
  Eigen::Index column = 0;
  for (const StateBlock& block : track.blocks) {
    const Eigen::Index target =
        block.offset == kRigIdx ? 0 : block.offset - state.CloneIdx(0) + rig_dims;
    stacked->jacobian.block(row, target, track.num_rows(), block.size) =
        track.jacobian.middleCols(column, block.size);
    column += block.size;
  }
  stacked->residual.segment(row, track.num_rows()) = track.residual;
}

Measurement Stack(const FilterState& state, const std::vector<Measurement>& tracks) {
  Eigen::Index num_rows = 0;
  for (const Measurement& track : tracks) {
    num_rows += track.num_rows();
  }
  Measurement stacked;
  stacked.blocks = TrackColumns(state);
  Eigen::Index width = 0;
  for (const StateBlock& block : stacked.blocks) {
    width += block.size;
  }
  stacked.jacobian = Eigen::MatrixXd::Zero(num_rows, width);
  stacked.residual.resize(num_rows);
  Eigen::Index row = 0;
  for (const Measurement& track : tracks) {
    Append(state, track, row, &stacked);
    row += track.num_rows();
  }
  return stacked;
}

}  // namespace

void TrackUpdateOptions::Validate() const {
  if (!(sigma_px > 0.0 && min_views >= 2 && max_tracks >= 1 && gate_quantile > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument,
                "tracks: sigma_px and gate_quantile must be positive, min_views at least 2");
  }
  triangulate.Validate();
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

std::optional<Measurement> TrackMeasurement(const FilterState& state, const Camera& camera,
                                            std::span<const CameraView> views,
                                            std::span<const Observation> observations,
                                            const TrackUpdateOptions& options) {
  std::vector<Sight> sights;
  std::vector<StateBlock> blocks;
  for (const Observation& observation : observations) {
    const int clone = FindClone(state, observation.frame_id);
    CAIRN_CHECK(clone >= 0, "sights are at clones");
    sights.push_back(
        {&views[static_cast<size_t>(clone)], observation.pixel, observation.ray_in_cam});
    blocks.push_back({state.CloneIdx(clone), kCloneDim});
  }
  const auto x_in_local = Triangulate(camera, sights, options.sigma_px, options.triangulate);
  if (!x_in_local) {
    return std::nullopt;
  }
  // Columns: the point, the clones in turn, the rig, the residual.
  const int num_views = static_cast<int>(sights.size());
  const int rig_dims = state.estimates_rig() ? kRigDim : 0;
  const int width = 3 + kCloneDim * num_views + rig_dims;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * num_views, width + 1);
  for (int i = 0; i < num_views; ++i) {
    const Sight& sight = sights[static_cast<size_t>(i)];
    const auto predicted = PredictPixel(camera, *sight.view, *x_in_local);
    if (!predicted) {
      return std::nullopt;
    }
    rows.block<2, 3>(2 * i, 0) = predicted->by_local;
    rows.block<2, kCloneDim>(2 * i, 3 + kCloneDim * i) =
        ByClone(*predicted, *sight.view, *x_in_local);
    if (rig_dims > 0) {
      rows.block<2, kRigDim>(2 * i, width - kRigDim) = ByRig(*predicted, state.rig());
    }
    rows.block<2, 1>(2 * i, width) = sight.pixel - predicted->pixel;
  }
  rows /= options.sigma_px;
  Triangularize(3, rows);
  if (rig_dims > 0) {
    blocks.push_back({kRigIdx, kRigDim});
  }
  return Measurement{std::move(blocks), rows.block(3, 3, 2 * num_views - 3, width - 3),
                     rows.col(width).tail(2 * num_views - 3)};
}

TrackUpdateCounts UpdateFromTracks(const Camera& camera,
                                   std::vector<std::vector<Observation>> tracks,
                                   const TrackUpdateOptions& options, FilterState* state) {
  std::stable_sort(tracks.begin(), tracks.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  TrackUpdateCounts counts;
  const std::vector<CameraView> views = ViewsOfClones(*state);
  std::vector<Measurement> accepted;
  std::vector<const std::vector<Observation>*> accepted_tracks;
  for (const std::vector<Observation>& track : tracks) {
    if (static_cast<int>(accepted.size()) == options.max_tracks) {
      break;
    }
    auto measurement = TrackMeasurement(*state, camera, views, track, options);
    if (!measurement) {
      ++counts.num_not_triangulated;
    } else if (!(state->SquaredMahalanobis(*measurement) <
                 ChiSquareQuantile(measurement->num_rows(), options.gate_quantile))) {
      ++counts.num_gated;
    } else {
      accepted.push_back(std::move(*measurement));
      accepted_tracks.push_back(&track);
    }
  }
  if (accepted.empty()) {
    return counts;
  }
  counts.num_used = static_cast<int>(accepted.size());
  bool linearized = true;  // `accepted` is at the present state.
  const auto linearize = [&](const FilterState& at) {
    if (!std::exchange(linearized, false)) {
      accepted.clear();
      const std::vector<CameraView> moved_views = ViewsOfClones(at);
      for (const std::vector<Observation>* track : accepted_tracks) {
        if (auto measurement = TrackMeasurement(at, camera, moved_views, *track, options)) {
          accepted.push_back(std::move(*measurement));
        }
      }
    }
    Measurement stacked = Stack(at, accepted);
    Compress(&stacked);
    return stacked;
  };
  IteratedUpdate(linearize, state);
  return counts;
}

}  // namespace cairn::fusion
