#include "cli/eval_queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "cli/query_features.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/logging.h"
#include "core/printable.h"
#include "eval/reference_alignment.h"
#include "ingest/colmap/colmap_reader.h"

namespace cairn {
namespace {

// If the shared images of map and model differ by more than this, they merely have the same names:
// the model is another drive with the same frame numbers.
constexpr double kMaxAlignmentResidualM = 0.5;

std::vector<KeyframeRecord> AllKeyframes(const MapSnapshot& map) {
  std::vector<KeyframeRecord> keyframes;
  for (const SessionRecord& session : map.Sessions()) {
    const std::vector<KeyframeRecord> of_session = map.KeyframesOfSession(session.id);
    keyframes.insert(keyframes.end(), of_session.begin(), of_session.end());
  }
  return keyframes;
}

// Returns nothing, with the reason in `why_not`, if the map cannot place the model.
std::optional<ReferenceAlignment> AlignToMap(const Reconstruction& reconstruction,
                                             const std::vector<KeyframeRecord>& keyframes,
                                             std::string* why_not) {
  const std::optional<ReferenceAlignment> alignment = AlignToKeyframes(reconstruction, keyframes);
  if (!alignment) {
    *why_not = "the map holds fewer than three images of the model";
    return std::nullopt;
  }
  if (alignment->median_residual_m > kMaxAlignmentResidualM) {
    *why_not = fmt::format("the {} images that map and model share by name are {:.2f} m apart",
                           alignment->num_shared_images, alignment->median_residual_m);
    return std::nullopt;
  }
  LogInfo(
      "reference: the model, aligned to {} of {} images of the map; residual {:.4f} m median, "
      "{:.4f} m largest; the radii of answers are judged with {:.4f} m and {:.4f} deg of the "
      "reference",
      alignment->num_fitting_images, alignment->num_shared_images, alignment->median_residual_m,
      alignment->max_residual_m, alignment->radius68_m, kDegPerRad * alignment->radius68_rad);
  if (alignment->num_fitting_images < alignment->num_shared_images &&
      alignment->max_residual_m > kMaxAlignmentResidualM) {
    LogWarning(
        "{} images of the map do not stand where the model has them, by up to {:.2f} m; answers "
        "there are judged by the model",
        alignment->num_shared_images - alignment->num_fitting_images, alignment->max_residual_m);
  }
  return alignment;
}

// Where the model stands, and in which frame that is right.
struct PlacedReference {
  Sim3d ecef_from_world;
  ReferenceFrame frame = ReferenceFrame::kEarth;
  double radius_m = 0.0, radius_rad = 0.0;  // As EvalQuery's.
};

PlacedReference PlaceReference(const Reconstruction& reconstruction,
                               const EvalQueryArguments& arguments,
                               const GeoregisterOptions& georegister,
                               const std::vector<KeyframeRecord>& keyframes) {
  std::string why_not = "--align-to positions";
  if (arguments.reference_source != ReferenceSource::kPositions) {
    const std::optional<ReferenceAlignment> aligned =
        AlignToMap(reconstruction, keyframes, &why_not);
    if (aligned) {
      return {aligned->ecef_from_world, ReferenceFrame::kMap, aligned->radius68_m,
              aligned->radius68_rad};
    }
    if (arguments.reference_source == ReferenceSource::kMap) {
      throw Error(ErrorCode::kBadInput, "cannot align the model to the map: " + why_not);
    }
  }
  if (!arguments.reconstruction.HasPositions()) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("the true poses are unknown; give --georef CSV or --gps ({})", why_not));
  }
  ReconstructionArguments with_photos = arguments.reconstruction;
  with_photos.photo_dir = arguments.image_dir;
  const Georegistration fit = GeoregisterByArguments(reconstruction, with_photos, georegister);
  LogInfo("reference: the model, fitted to {} positions ({}); residual {:.3f} m median; up from {}",
          fit.num_positions, why_not, fit.median_residual_m, fit.up.source);
  for (const std::string& note : fit.notes) {
    LogWarning("{}", note);
  }
  return {fit.ecef_from_world, ReferenceFrame::kEarth, 0.0, 0.0};
}

// The names of the queries: those of the list, or all images of the model that the map does not
// contain.
std::set<std::string> QueryNames(const Reconstruction& reconstruction,
                                 const EvalQueryArguments& arguments,
                                 const std::vector<KeyframeRecord>& keyframes) {
  std::set<std::string> in_map;
  for (const KeyframeRecord& keyframe : keyframes) {
    in_map.insert(keyframe.image_name);
  }
  std::set<std::string> names;
  for (const ReconImage& image : reconstruction.images) {
    names.insert(image.name);
  }
  if (arguments.image_list_path.empty()) {
    std::erase_if(names, [&](const std::string& name) { return in_map.contains(name); });
    LogInfo("queries: {} of {} images of the model; the map holds the others", names.size(),
            reconstruction.images.size());
    return names;
  }
  std::set<std::string> listed;
  for (const std::string& name : ReadImageList(arguments.image_list_path)) {
    if (!names.contains(name)) {
      throw Error(ErrorCode::kBadInput, fmt::format("{}: the model has no image '{}'",
                                                    arguments.image_list_path, Excerpt(name)));
    }
    if (in_map.contains(name)) {
      LogWarning("query {} is also a mapping image; its errors will be too small", Excerpt(name));
    }
    listed.insert(name);
  }
  return listed;
}

// Without a database, the features come from the photos.
Reconstruction ReadModel(const EvalQueryArguments& arguments) {
  const ReconstructionArguments& model = arguments.reconstruction;
  if (model.model_dir.empty() || (model.database_path.empty() && arguments.image_dir.empty())) {
    throw Error(ErrorCode::kInvalidArgument,
                "no queries given; use --queries FILE, or --model DIR with --database FILE or, for "
                "features from the photos, with --image-dir DIR");
  }
  if (model.database_path.empty()) {
    return ReadColmapPoses(model.model_dir);
  }
  ColmapInput input;
  input.model_dir = model.model_dir;
  input.database_path = model.database_path;
  return ReadColmap(input);
}

std::vector<EvalQuery> QueriesFromModel(const EvalQueryArguments& arguments,
                                        const GeoregisterOptions& georegister,
                                        const MapSnapshot& map) {
  const Reconstruction reconstruction = ReadModel(arguments);
  const std::vector<KeyframeRecord> keyframes = AllKeyframes(map);
  const std::set<std::string> names = QueryNames(reconstruction, arguments, keyframes);
  const PlacedReference reference =
      PlaceReference(reconstruction, arguments, georegister, keyframes);
  std::vector<EvalQuery> queries =
      QueriesFromReconstruction(reconstruction, reference.ecef_from_world, arguments.image_dir);
  for (EvalQuery& query : queries) {
    query.reference_frame = reference.frame;
    query.reference_radius_m = reference.radius_m;
    query.reference_radius_rad = reference.radius_rad;
  }
  std::erase_if(queries, [&](const EvalQuery& query) { return !names.contains(query.name); });
  return queries;
}

}  // namespace

std::vector<EvalQuery> LoadEvalQueries(const EvalQueryArguments& arguments,
                                       const GeoregisterOptions& georegister,
                                       const MapSnapshot& map) {
  std::vector<EvalQuery> queries;
  if (arguments.query_list_path.empty()) {
    queries = QueriesFromModel(arguments, georegister, map);
  } else {
    queries = ReadQueryList(arguments.query_list_path);
    ReadQueryFeatures(&queries);
  }
  if (queries.empty()) {
    throw Error(ErrorCode::kBadInput,
                "no queries remain: the map contains every image of the "
                "model, or the list is empty");
  }
  return queries;
}

}  // namespace cairn
