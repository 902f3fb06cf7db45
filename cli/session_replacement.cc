#include "cli/session_replacement.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/logging.h"
#include "core/printable.h"
#include "ingest/session_refused.h"

namespace cairn {
namespace {

// Two reconstructions of the same photos, each placed by GPS, differ by a few errors of GPS.
constexpr double kSamePlaceM = 50.0;
// A session that replaces another one from so far away is of another place.
constexpr double kElsewhereM = 1000.0;

// How the new session relates to the session of the map with the same name.
struct Relation {
  int64_t num_keyframes = 0;
  int64_t num_same = 0;  // Keyframes with a photo of the same name at the same place.
  double distance_m = std::numeric_limits<double>::infinity();  // Between the nearest cameras.
};

Relation Relate(const std::vector<KeyframeRecord>& keyframes, const PlacedReconstruction& session) {
  std::unordered_map<std::string, Eigen::Vector3d> center_of_name;
  std::vector<Eigen::Vector3d> centers;
  for (const ReconImage& image : session.reconstruction.images) {
    centers.push_back(session.georegistration.ecef_from_world *
                      image.cam_from_world.Inverse().translation);
    center_of_name.emplace(image.name, centers.back());
  }
  Relation relation;
  relation.num_keyframes = static_cast<int64_t>(keyframes.size());
  const size_t step = 1 + centers.size() / 1000;  // A thousand cameras tell where a session is.
  for (const KeyframeRecord& keyframe : keyframes) {
    const Eigen::Vector3d center = keyframe.cam_from_ecef.Inverse().translation;
    const auto same = center_of_name.find(keyframe.image_name);
    if (same != center_of_name.end() && (same->second - center).norm() < kSamePlaceM) {
      ++relation.num_same;
      relation.distance_m = std::min(relation.distance_m, (same->second - center).norm());
    }
    if (relation.distance_m > kSamePlaceM) {
      for (size_t i = 0; i < centers.size(); i += step) {
        relation.distance_m = std::min(relation.distance_m, (centers[i] - center).norm());
      }
    }
  }
  return relation;
}

std::string DistanceText(double distance_m) {
  return distance_m < 1000.0 ? fmt::format("{:.0f} m", distance_m)
                             : fmt::format("{:.1f} km", 1e-3 * distance_m);
}

}  // namespace

void CheckReplacement(const MapSnapshot& map, const PlacedReconstruction& session,
                      bool name_was_given) {
  const std::string& name = session.options.session_name;
  const std::optional<SessionRecord> known = map.FindSession(name);
  if (!known) {
    return;
  }
  const std::vector<KeyframeRecord> keyframes = map.KeyframesOfSession(known->id);
  const Relation relation = Relate(keyframes, session);
  if (name_was_given && relation.distance_m > kElsewhereM && relation.num_keyframes > 0) {
    LogWarning(
        "session '{}' replaces one of {} photos that stands {} away; `cairn rollback` brings it "
        "back",
        Excerpt(name), relation.num_keyframes, DistanceText(relation.distance_m));
  }
  if (!name_was_given && 2 * relation.num_same < relation.num_keyframes) {
    throw SessionRefused(
        fmt::format("the map has a session '{0}' already, with {1} other photos, the nearest {2} "
                    "away. '{0}' is the name of the database's folder, which is the default. Give "
                    "this session a name of its own (--session NAME), or replace that session "
                    "(--session '{0}')",
                    Excerpt(name), relation.num_keyframes - relation.num_same,
                    DistanceText(relation.distance_m)));
  }
}

}  // namespace cairn
