#include "ingest/place/compare_with_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/evenly_of.h"
#include "core/frames.h"
#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "core/radius68.h"
#include "core/statistics.h"
#include "engine/localizer.h"
#include "ingest/place/image_query.h"
#include "ingest/place/in_map_accuracy.h"
#include "ingest/place/tiles_around.h"
#include "ingest/tiles/near_view.h"

namespace cairn {
namespace {

constexpr int kMaxExpected = 60;
// Photos of elsewhere cost several times as much as photos that the map knows, and more if they are
// searched in many tiles.
constexpr int kMaxSought = 24;
constexpr size_t kFirstNear = 12, kFirstAnywhere = 6;
// Accuracy of the priors of expected photos; the engine searches 50 m around.
constexpr double kExpectedAccuracyM = 15.0;
// Of photos that are sought near by: the engine searches twice as far, which is kReachM.
constexpr double kSoughtAccuracyM = 50.0;

// Others are searched in tiles within this distance of the session.
constexpr double kMaxSearchedM = 2000.0;

Eigen::Vector3d MiddleOf(const std::vector<Eigen::Vector3d>& centers) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& center : centers) {
    middle += center;
  }
  return middle / static_cast<double>(std::max<size_t>(1, centers.size()));
}

double SpreadOf(const std::vector<Eigen::Vector3d>& centers) {
  const Eigen::Vector3d middle = MiddleOf(centers);
  double sum_sq_m = 0.0;
  for (const Eigen::Vector3d& center : centers) {
    sum_sq_m += (center - middle).squaredNorm();
  }
  return std::sqrt(sum_sq_m);
}

std::vector<Eigen::Vector3d> CentersOf(const PlacedSession& session) {
  std::vector<Eigen::Vector3d> centers;
  for (const Rigid3d& cam_from_ecef : session.cam_from_ecef) {
    centers.push_back(cam_from_ecef.Inverse().translation);
  }
  return centers;
}

// The photos of the map, by tile; loads a tile when it is asked for first.
class KnownViews {
 public:
  explicit KnownViews(const KnownTiles& map) : map_(map) {}

  // Returns whether a photo of the map's tile looks from about the same place into about the same
  // direction.
  bool Knows(TileId tile_id, const Rigid3d& cam_from_ecef) {
    const double cos_near = std::cos(kNearViewRad);
    const View view = ViewOf(cam_from_ecef.Inverse());
    const std::vector<View>& known = ViewsOf(tile_id);
    return std::any_of(known.begin(), known.end(), [&](const View& other) {
      return (other.center_in_ecef - view.center_in_ecef).norm() <= kNearViewM &&
             other.axis_in_ecef.dot(view.axis_in_ecef) >= cos_near;
    });
  }

  // Fills in the sessions of the photos that were loaded, and the spread of the earliest.
  void Describe(MapComparison* comparison) const {
    comparison->known_sessions.clear();
    for (const auto& [session, centers] : centers_of_session_) {
      comparison->known_sessions.push_back(session);
    }
    comparison->map_spread_m =
        centers_of_session_.empty() ? 0.0 : SpreadOf(centers_of_session_.begin()->second);
  }

 private:
  struct View {
    Eigen::Vector3d center_in_ecef, axis_in_ecef;
  };

  static View ViewOf(const Rigid3d& ecef_from_cam) {
    return {ecef_from_cam.translation, ecef_from_cam.rotation * Eigen::Vector3d::UnitZ()};
  }

  const std::vector<View>& ViewsOf(TileId tile_id) {
    const auto [entry, is_new] = views_of_tile_.try_emplace(tile_id);
    const std::shared_ptr<const Tile> tile = is_new ? map_.Find(tile_id) : nullptr;
    if (tile != nullptr) {
      const Rigid3d ecef_from_tile = EcefFromEnu(tile_id.Anchor());
      for (const TileKeyframe& keyframe : tile->keyframes) {
        entry->second.push_back(ViewOf(ecef_from_tile * keyframe.cam_from_tile.Inverse()));
        centers_of_session_[keyframe.session_id].push_back(entry->second.back().center_in_ecef);
      }
    }
    return entry->second;
  }

  const KnownTiles& map_;
  std::map<TileId, std::vector<View>> views_of_tile_;
  std::map<SessionId, std::vector<Eigen::Vector3d>> centers_of_session_;
};

// The first quarter is spread evenly, and so is the first half.
std::vector<int> EvenOnesFirst(const std::vector<int>& all) {
  std::vector<int> ordered;
  for (const size_t first : {0, 2, 1, 3}) {
    for (size_t i = first; i < all.size(); i += 4) {
      ordered.push_back(all[i]);
    }
  }
  return ordered;
}

PhotosToAsk ChooseAmong(const PlacedSession& session, const KnownTiles& map, KnownViews* known) {
  std::vector<int> expected, near, beyond;
  for (const auto& [tile_id, images_of_tile] : session.images_of_tile) {
    for (const int image_idx : images_of_tile) {
      const Rigid3d& cam_from_ecef = session.cam_from_ecef[static_cast<size_t>(image_idx)];
      if (known->Knows(tile_id, cam_from_ecef)) {
        expected.push_back(image_idx);
      } else {
        const GeoBox around =
            BoxAround(GeodeticFromEcef(cam_from_ecef.Inverse().translation), kReachM);
        (map.FindTiles(around).empty() ? beyond : near).push_back(image_idx);
      }
    }
  }
  return {EvenlyOf(expected, kMaxExpected), EvenOnesFirst(EvenlyOf(near, kMaxSought)),
          EvenOnesFirst(EvenlyOf(beyond, kMaxSought))};
}

// Without an accuracy, the place is unknown.
LocalizeQuery QueryOf(const Reconstruction& reconstruction, const PlacedSession& session,
                      int image_idx, std::optional<double> accuracy_m, const std::string& codec) {
  const Rigid3d& cam_from_ecef = session.cam_from_ecef[static_cast<size_t>(image_idx)];
  const Geodetic place = GeodeticFromEcef(cam_from_ecef.Inverse().translation);
  LocalizeQuery query =
      QueryOfImage(reconstruction, image_idx, place, accuracy_m.value_or(0.0), codec);
  if (!accuracy_m) {
    query.prior.reset();
  }
  query.down_in_cam =
      (cam_from_ecef.rotation * (EcefFromEnu(place).rotation * DownInEnu())).normalized();
  return query;
}

// Facades have no back: a photo that recognizes more than half of its landmarks from the other side
// shows them mirrored.
bool IsFromBehind(const LocalizeResult& result) {
  const auto num_behind = std::count_if(
      result.matches.begin(), result.matches.end(),
      [](const LocalizeMatch& match) { return match.traits.azimuth_rad > 0.5 * kPi; });
  return 2 * num_behind > static_cast<int64_t>(result.matches.size());
}

// The residuals of the fit after the bending: what each photo tells that the others do not.
void FitBending(const std::vector<PosePair>& agreeing, MapComparison* comparison) {
  std::vector<PosePair> moved = agreeing;
  for (PosePair& pair : moved) {
    pair.cam_from_ecef = CamFromTarget(pair.cam_from_ecef, comparison->fit.map_from_session);
  }
  comparison->bending = Bending::Fit(moved);
  std::vector<double> residuals_m;
  std::vector<PhotoDisagreement> photos;
  for (size_t i = 0; i < comparison->bending.shift().surprises().size(); ++i) {
    residuals_m.push_back(comparison->bending.shift().surprises()[i].norm());
    photos.push_back({residuals_m.back(), moved[i].accuracy_m});
  }
  if (!residuals_m.empty()) {
    comparison->fit.disagreement_m = UnpredictedRadius68(photos);
    comparison->fit.median_residual_m = Median(std::move(residuals_m));
  }
}

// Fills in the fit, the anchoring and the bending.
void FitPairs(const std::vector<PosePair>& pairs, const ComparisonOptions& how,
              MapComparison* comparison) {
  ConsistencyOptions options;
  options.scale_sigma =
      std::max(options.scale_sigma,
               how.position_accuracy_m / kRadius68PerSigma2d / std::max(1.0, comparison->spread_m));
  const ConsistentFrames consistent = FindConsistentFrames(pairs, options);
  AnchorEvidence& anchoring = comparison->anchoring;
  anchoring.num_answers = static_cast<int>(pairs.size());
  anchoring.winner = consistent.winner;
  anchoring.rival = consistent.rival;
  anchoring.rival_is_apart = consistent.rival_is_apart;
  // The expected photos were asked for first.
  comparison->num_found_by_rival = static_cast<int>(std::count(
      consistent.is_rival.begin() + comparison->num_localized, consistent.is_rival.end(), true));
  comparison->bending = Bending();
  // A group of a session that is not anchored proves nothing; one motion has to explain its photos.
  if (!IsAnchored(anchoring)) {
    comparison->fit = FitPlacement(pairs, PlacementFitOptions());
    return;
  }
  std::vector<PosePair> agreeing;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (consistent.agrees[i]) {
      agreeing.push_back(pairs[i]);
    }
  }
  comparison->fit = FitPlacement(agreeing, PlacementFitOptions());
  comparison->fit.agrees = consistent.agrees;
  comparison->fit.num_agreeing = consistent.winner.num_frames;
  if (how.may_bend && anchoring.winner.num_places >= kIslandPlaces) {
    FitBending(agreeing, comparison);
  }
}

// A sure answer may come from a part of the keypoints. What a session shows from behind, and where
// it stands, is judged by all of them.
LocalizerOptions MostPrecise() {
  LocalizerOptions options;
  options.refinement.mode = RefinementMode::kAlways;
  return options;
}

std::vector<Geodetic> PlacesOf(const PlacedSession& session, const std::vector<int>& photos) {
  std::vector<Geodetic> places;
  for (const int image_idx : photos) {
    places.push_back(GeodeticFromEcef(
        session.cam_from_ecef[static_cast<size_t>(image_idx)].Inverse().translation));
  }
  return places;
}

// Asks the map for photos and collects what it says. `beyond` are those that are searched anywhere.
class MapInquiry {
 public:
  MapInquiry(const Reconstruction& reconstruction, const PlacedSession& session,
             const KnownTiles& map, const std::vector<int>& beyond,
             const ComparisonOptions& options)
      : reconstruction_(reconstruction),
        session_(session),
        options_(options),
        codec_(map.CurrentCodebook()->CodecName()),
        near_(map, MostPrecise(), map.memory()->searchable()),
        around_(map, PlacesOf(session, beyond), kMaxSearchedM),
        anywhere_(around_, MostPrecise(), map.memory()->searchable()) {}

  bool has_tiles_around() const { return !around_.empty(); }

  // Searches the photos with this accuracy around where they stand, or everywhere without one.
  // Returns the number of photos that the map recognizes with this confidence.
  int Ask(std::span<const int> images, std::optional<double> accuracy_m, double least_confidence) {
    const Localizer& localizer = accuracy_m ? near_ : anywhere_;
    std::vector<LocalizeResult> results(images.size());
    ParallelFor(static_cast<int>(images.size()), options_.num_threads, [&](int i) {
      results[static_cast<size_t>(i)] = localizer.Localize(
          QueryOf(reconstruction_, session_, images[static_cast<size_t>(i)], accuracy_m, codec_));
    });
    int num_recognized = 0;
    for (size_t i = 0; i < images.size(); ++i) {
      asked_.push_back(images[i]);
      if (results[i].localized && results[i].confidence >= least_confidence) {
        ++num_recognized;
        is_from_behind_.push_back(IsFromBehind(results[i]));
        pairs_.push_back({session_.cam_from_ecef[static_cast<size_t>(images[i])],
                          results[i].cam_from_ecef, results[i].position_accuracy_m,
                          results[i].rotation_accuracy_rad});
        recognized_.push_back(images[i]);
      }
    }
    return num_recognized;
  }

  void Fit(KnownViews* known, MapComparison* comparison) const {
    comparison->num_from_behind =
        static_cast<int>(std::count(is_from_behind_.begin(), is_from_behind_.end(), true));
    if (pairs_.empty()) {
      return;
    }
    FitPairs(pairs_, options_, comparison);
    std::set<int> agreeing;
    comparison->num_agreeing_from_behind = 0;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      if (comparison->fit.agrees[i]) {
        agreeing.insert(recognized_[i]);
        comparison->num_agreeing_from_behind += is_from_behind_[i] ? 1 : 0;
      }
    }
    comparison->num_expected_after = comparison->num_agreeing_after = 0;
    for (const int image_idx : asked_) {
      const Rigid3d moved = CamFromTarget(session_.cam_from_ecef[static_cast<size_t>(image_idx)],
                                          comparison->fit.map_from_session);
      if (known->Knows(TileId::Containing(GeodeticFromEcef(moved.Inverse().translation)), moved)) {
        ++comparison->num_expected_after;
        comparison->num_agreeing_after += agreeing.contains(image_idx) ? 1 : 0;
      }
    }
  }

 private:
  const Reconstruction& reconstruction_;
  const PlacedSession& session_;
  const ComparisonOptions& options_;
  const std::string codec_;
  const Localizer near_;
  const TilesAround around_;
  const Localizer anywhere_;
  std::vector<int> asked_;
  // Of the recognized photos, in parallel; expected photos first.
  std::vector<int> recognized_;
  std::vector<PosePair> pairs_;
  std::vector<bool> is_from_behind_;
};

bool IsDecided(const MapComparison& comparison) {
  return IsJudged(comparison) && IsAnchored(comparison.anchoring) &&
         2 * comparison.fit.num_agreeing >= comparison.num_expected;
}

// Asks for the first photos, and for the others if those leave the session undecided.
void Seek(const std::vector<int>& photos, size_t num_first, std::optional<double> accuracy_m,
          KnownViews* known, MapInquiry* inquiry, MapComparison* comparison) {
  const size_t num_at_first = std::min(num_first, photos.size());
  const std::span<const int> all(photos);
  for (const std::span<const int> part : {all.first(num_at_first), all.subspan(num_at_first)}) {
    const int num_found = inquiry->Ask(part, accuracy_m, kSureConfidence);
    comparison->num_sought += static_cast<int>(part.size());
    comparison->num_found += num_found;
    inquiry->Fit(known, comparison);
    const bool is_contradicted = 2 * comparison->num_found_by_rival > comparison->num_found;
    if (num_found == 0 || (IsDecided(*comparison) && !is_contradicted)) {
      return;
    }
  }
}

}  // namespace

bool IsKnown(const MapComparison& comparison) {
  return comparison.num_localized >= kLeastPhotosToJudge ||
         2 * comparison.num_recognized() >= comparison.num_asked();
}

bool IsJudged(const MapComparison& comparison) {
  // Ten photos do not agree by chance.
  constexpr int kMany = 10;
  const PlacementFit& fit = comparison.fit;
  return fit.num_agreeing >= kLeastPhotosToJudge &&
         (fit.num_agreeing >= kMany || fit.moved_m <= kNearViewM ||
          2 * comparison.num_agreeing_after >= comparison.num_expected_after);
}

PhotosToAsk ChoosePhotos(const PlacedSession& session, const KnownTiles& map) {
  KnownViews known(map);
  return ChooseAmong(session, map, &known);
}

MapComparison CompareWithMap(const Reconstruction& reconstruction, const PlacedSession& session,
                             const KnownTiles& map, const ComparisonOptions& options) {
  MapComparison comparison;
  comparison.spread_m = SpreadOf(CentersOf(session));
  comparison.anchoring.session = {static_cast<int>(session.cam_from_ecef.size()),
                                  CountPlaces(session.cam_from_ecef, 2 * kIslandPlaces),
                                  ExtentM(session.cam_from_ecef)};
  KnownViews known(map);
  const PhotosToAsk photos = ChooseAmong(session, map, &known);
  comparison.num_expected = static_cast<int>(photos.expected.size());
  if (photos.expected.empty() && photos.sought_near.empty()) {
    comparison.nearest_tile_m = DistanceToMapM(map, PlacesOf(session, photos.sought_anywhere));
  }
  if (map.CurrentCodebook() != nullptr) {
    MapInquiry inquiry(reconstruction, session, map, photos.sought_anywhere, options);
    comparison.num_localized = inquiry.Ask(photos.expected, kExpectedAccuracyM, 0.0);
    inquiry.Fit(&known, &comparison);
    Seek(photos.sought_near, kFirstNear, kSoughtAccuracyM, &known, &inquiry, &comparison);
    if (inquiry.has_tiles_around()) {
      Seek(photos.sought_anywhere, kFirstAnywhere, std::nullopt, &known, &inquiry, &comparison);
    }
  }
  known.Describe(&comparison);
  return comparison;
}

}  // namespace cairn
