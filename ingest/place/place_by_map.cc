#include "ingest/place/place_by_map.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/check.h"
#include "core/evenly_of.h"
#include "core/parallel_for.h"
#include "engine/localizer.h"
#include "ingest/anchor/pose_pair.h"
#include "ingest/place/fit_placement.h"
#include "ingest/place/image_query.h"

namespace cairn {
namespace {

constexpr size_t kMaxAsked = 24;
constexpr double kRoughAccuracyM = 50.0;  // The engine searches twice as far.
constexpr int kLeastAgreeing = 3;
constexpr PlacementFitOptions kAgreement;

// A recognized photo.
struct SeenByMap {
  Rigid3d cam_from_world;
  LocalizeResult answer;
};

std::vector<int> ChooseImages(const std::vector<std::optional<Geodetic>>& rough_positions) {
  std::vector<int> known;
  for (size_t i = 0; i < rough_positions.size(); ++i) {
    if (rough_positions[i]) {
      known.push_back(static_cast<int>(i));
    }
  }
  return EvenlyOf(std::move(known), kMaxAsked);
}

// The similarity that puts `a` where the map sees it and has the map's distance from `a` to `b`.
std::optional<Sim3d> SimilarityOf(const SeenByMap& a, const SeenByMap& b) {
  const Rigid3d world_from_a = a.cam_from_world.Inverse();
  const Rigid3d ecef_from_a = a.answer.cam_from_ecef.Inverse();
  const double in_world =
      (b.cam_from_world.Inverse().translation - world_from_a.translation).norm();
  const double in_ecef_m =
      (b.answer.cam_from_ecef.Inverse().translation - ecef_from_a.translation).norm();
  if (!(in_world > 0.0) || !(in_ecef_m > 0.0)) {
    return std::nullopt;
  }
  Sim3d ecef_from_world;
  ecef_from_world.scale = in_ecef_m / in_world;
  ecef_from_world.rotation =
      (ecef_from_a.rotation * world_from_a.rotation.conjugate()).normalized();
  ecef_from_world.translation =
      ecef_from_a.translation -
      ecef_from_world.scale * (ecef_from_world.rotation * world_from_a.translation);
  return ecef_from_world;
}

// The sum of squared residuals, each at most that of a photo that does not agree: the less, the
// more photos agree.
double CostOf(const std::vector<SeenByMap>& seen, const Sim3d& ecef_from_world) {
  double cost = 0.0;
  for (const SeenByMap& photo : seen) {
    const Rigid3d placed = CamFromTarget(photo.cam_from_world, ecef_from_world);
    const double error =
        (placed.Inverse().translation - photo.answer.cam_from_ecef.Inverse().translation).norm() /
        kAgreement.max_residual_m;
    const bool agrees = RotationAngleRad(placed.rotation, photo.answer.cam_from_ecef.rotation) <=
                        kAgreement.max_residual_rad;
    cost += agrees ? std::min(1.0, error * error) : 1.0;
  }
  return cost;
}

std::optional<Sim3d> LargestAgreement(const std::vector<SeenByMap>& seen) {
  std::optional<Sim3d> best;
  double least_cost = static_cast<double>(seen.size());
  for (const SeenByMap& a : seen) {
    for (const SeenByMap& b : seen) {
      const std::optional<Sim3d> candidate = &a == &b ? std::nullopt : SimilarityOf(a, b);
      const double cost = candidate ? CostOf(seen, *candidate) : least_cost;
      if (cost < least_cost) {
        least_cost = cost;
        best = candidate;
      }
    }
  }
  return best;
}

// Fits all that agree.
void Refine(const std::vector<SeenByMap>& seen, const Sim3d& start, PlacementByMap* result) {
  std::vector<PosePair> pairs;
  for (const SeenByMap& photo : seen) {
    pairs.push_back({CamFromTarget(photo.cam_from_world, start), photo.answer.cam_from_ecef,
                     photo.answer.position_accuracy_m, photo.answer.rotation_accuracy_rad});
  }
  const PlacementFit fit = FitPlacement(pairs, kAgreement);
  result->num_agreeing = fit.num_agreeing;
  result->median_residual_m = fit.median_residual_m;
  if (fit.num_agreeing >= kLeastAgreeing && 2 * fit.num_agreeing >= result->num_recognized) {
    result->ecef_from_world = fit.map_from_session * start;
  }
}

}  // namespace

PlacementByMap PlaceByMap(const Reconstruction& reconstruction,
                          const std::vector<std::optional<Geodetic>>& rough_positions,
                          const KnownTiles& map, int num_threads) {
  CAIRN_CHECK(rough_positions.size() == reconstruction.images.size(), "a member for each image");
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  if (codebook == nullptr) {
    return {};
  }
  const std::vector<int> asked = ChooseImages(rough_positions);
  const Localizer localizer(map, LocalizerOptions(), map.memory()->searchable());
  std::vector<LocalizeResult> answers(asked.size());
  ParallelFor(static_cast<int>(asked.size()), num_threads, [&](int i) {
    const int image_idx = asked[static_cast<size_t>(i)];
    const Geodetic& about = *rough_positions[static_cast<size_t>(image_idx)];
    answers[static_cast<size_t>(i)] = localizer.Localize(
        QueryOfImage(reconstruction, image_idx, about, kRoughAccuracyM, codebook->CodecName()));
  });
  std::vector<SeenByMap> seen;
  for (size_t i = 0; i < asked.size(); ++i) {
    if (answers[i].localized && answers[i].confidence >= kSureConfidence) {
      seen.push_back({reconstruction.images[asked[i]].cam_from_world, std::move(answers[i])});
    }
  }
  PlacementByMap result;
  result.num_asked = static_cast<int>(asked.size());
  result.num_recognized = static_cast<int>(seen.size());
  if (const std::optional<Sim3d> start = LargestAgreement(seen)) {
    Refine(seen, *start, &result);
  }
  return result;
}

}  // namespace cairn
