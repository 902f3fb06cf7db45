#include "ingest/place/level_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "ingest/place/find_up.h"
#include "ingest/place/up_evidence.h"

namespace cairn {
namespace {

// More add time and no certainty.
constexpr size_t kMaxViews = 300, kMaxPositions = 300, kMaxRays = 3000;

// Of one photo, and of a session: as often as not, programs wrote the orientations that do not know
// them (then nearly always 1), or turned the pixels.
constexpr double kTrustInSensor = 0.9, kTrustInSession = 0.4, kTrustInUser = 0.999;

// Log likelihoods that are worth a word, and beyond which a figure says no more.
constexpr double kTelling = 1.0, kMaxWordedLogOdds = 20.0;

std::optional<PictureUp> StatedByUser(UpSource source) {
  switch (source) {
    case UpSource::kTop:
      return PictureUp::kTop;
    case UpSource::kLeft:
      return PictureUp::kLeft;
    case UpSource::kRight:
      return PictureUp::kRight;
    case UpSource::kBottom:
      return PictureUp::kBottom;
    case UpSource::kDown:
      return PictureUp::kBack;
    default:
      return std::nullopt;
  }
}

// The orientation whose down is this axis of the picture; nothing if it is none. COLMAP 4 states
// the EXIF orientation of a photo as its gravity. No sensor feels exactly an axis.
std::optional<int> OrientationInGravity(const Eigen::Vector3d& down_in_cam) {
  constexpr double kExact = 1e-9;
  const std::pair<int, Eigen::Vector3d> downs[] = {{1, Eigen::Vector3d::UnitY()},
                                                   {3, -Eigen::Vector3d::UnitY()},
                                                   {6, Eigen::Vector3d::UnitX()},
                                                   {8, -Eigen::Vector3d::UnitX()}};
  for (const auto& [orientation, down] : downs) {
    if ((down_in_cam - down).norm() < kExact) {
      return orientation;
    }
  }
  return std::nullopt;
}

UpView ViewOf(const ReconImage& image, std::optional<int> orientation,
              const std::optional<PictureUp>& by_user, double trust) {
  UpView view;
  view.cam_from_world = image.cam_from_world.rotation;
  if (image.down_in_cam) {
    const std::optional<int> stated = OrientationInGravity(*image.down_in_cam);
    if (!stated) {
      view.up_in_cam = -*image.down_in_cam;
    } else if (!orientation) {
      orientation = stated;
    }
  }
  if (by_user) {
    view.stated = by_user;
    view.trust = kTrustInUser;
    view.is_by_user = true;
    return view;
  }
  if (orientation) {
    view.stated = FromExifOrientation(*orientation);
    view.trust = trust;
  }
  return view;
}

template <typename T>
std::vector<T> Thinned(const std::vector<T>& values, size_t max_count) {
  if (values.size() <= max_count) {
    return values;
  }
  std::vector<T> thinned;
  for (size_t i = 0; i < max_count; ++i) {
    thinned.push_back(values[i * values.size() / max_count]);
  }
  return thinned;
}

std::vector<Eigen::Vector3d> RaysOf(const Reconstruction& reconstruction,
                                    double normalized_per_world) {
  std::vector<Eigen::Vector3d> centers;
  for (const ReconImage& image : reconstruction.images) {
    centers.push_back(image.cam_from_world.Inverse().translation);
  }
  std::vector<Eigen::Vector3d> rays;
  const size_t num_landmarks = reconstruction.landmarks.size();
  const size_t count = std::min(num_landmarks, kMaxRays);
  for (size_t i = 0; i < count; ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i * num_landmarks / count];
    if (!landmark.observations.empty()) {
      const ReconObservation& seen = landmark.observations[i % landmark.observations.size()];
      rays.push_back(normalized_per_world * (landmark.x_in_world - centers[seen.image_idx]));
    }
  }
  return rays;
}

const char* WordsFor(PictureUp up) {
  switch (up) {
    case PictureUp::kTop:
      return "the top of the stored pictures is up (--up top)";
    case PictureUp::kLeft:
      return "their left side is up, as in a phone held upright (--up left)";
    case PictureUp::kRight:
      return "their right side is up (--up right)";
    case PictureUp::kBottom:
      return "their bottom is up (--up bottom)";
    case PictureUp::kBack:
      break;
  }
  return "they look straight down (--up down)";
}

PictureUp MostFrequent(const HoldShares& shares) {
  const auto best = std::max_element(shares.begin(), shares.end() - 1);
  return kPictureUps[static_cast<size_t>(best - shares.begin())];
}

void RequireOdds(const UpChoice& choice, const GeoregisterOptions& options) {
  if (choice.Odds() >= options.least_up_odds) {
    return;
  }
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("georegistration: which way is up is not certain. Most likely, {}; {:.1f} times "
                  "less likely, {} ({:.0f} times would do). The positions lie on a line, or are "
                  "too rough to tell. Photos whose EXIF has an orientation may tell (of a model: "
                  "--photos DIR), or say how the photos lie: --up top, left, right, bottom or down",
                  WordsFor(MostFrequent(choice.score.shares)), choice.Odds(),
                  WordsFor(MostFrequent(choice.next_score.shares)), options.least_up_odds));
}

// Few programs mirror photos: one model of this many is expected to show the mirror image.
constexpr double kModelsPerMirror = 1000.0;

// The problem as it would be had a program mirrored the pixels, and with them the model: all of the
// world with the other sign of x, seen by cameras with the other sign of x. EXIF orientations and
// gravity are those of the camera, which mirrors nothing.
UpProblem MirroredBack(UpProblem problem) {
  for (UpView& view : problem.views) {
    Eigen::Quaterniond& q = view.cam_from_world;
    q = Eigen::Quaterniond(q.w(), q.x(), -q.y(), -q.z());
  }
  for (SimilarityProblem::Position& position : problem.positions) {
    position.center_in_world.x() *= -1.0;
  }
  for (Eigen::Vector3d& ray : problem.rays_in_world) {
    ray.x() *= -1.0;
  }
  return problem;
}

// A mirrored walk with bends fits its positions only upside down, and its mirror image upright. A
// straight walk fits both ways, and passes. Returns how many times better the mirror image explains
// all that is known.
double RequireNoMirror(const UpProblem& problem, const UpChoice& choice) {
  const UpChoice mirrored = FindUp(UpEvidence(MirroredBack(problem)));
  const double odds =
      std::exp(std::min(mirrored.score.Total() - choice.score.Total(), kMaxWordedLogOdds));
  if (odds > kModelsPerMirror) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format(
            "georegistration: the model looks mirrored. Its mirror image, with the cameras "
            "upright, explains the positions {:.0f} times better than the model itself "
            "({:.0f} times would do). Check whether latitude and longitude of the positions "
            "have changed places, and whether the program that wrote the photos or their "
            "keypoints mirrors images. If neither is so, say how the photos lie: --up top, "
            "left, right, bottom or down",
            odds, kModelsPerMirror));
  }
  return odds;
}

// What makes the choice better than the next one.
std::string SourceOf(const UpChoice& choice, bool by_user, bool has_gravity) {
  std::string source;
  const auto add = [&](const char* words) {
    source += source.empty() ? "" : ", ";
    source += words;
  };
  const UpScore& best = choice.score;
  const UpScore& next = choice.next_score;
  if (by_user) {
    add("--up");
  } else if (best.stated - next.stated > kTelling) {
    add("EXIF orientations");
  }
  if (best.cameras - next.cameras > kTelling) {
    add(has_gravity ? "gravity of the photos" : "the directions of the cameras");
  }
  if (best.positions - next.positions > kTelling) {
    add("the bends of the walk");
  }
  if (best.ground - next.ground > kTelling) {
    add("the ground below the cameras");
  }
  return source.empty() ? "how people hold cameras" : source;
}

void RequireOrientations(const ImageOrientations& orientations) {
  if (std::none_of(orientations.begin(), orientations.end(),
                   [](const std::optional<int>& known) { return known.has_value(); })) {
    throw Error(ErrorCode::kBadInput,
                "georegistration: --up photos needs photos whose EXIF has an orientation, and none "
                "was found; name their folder with --photos DIR");
  }
}

// What all else says of up, if the user's word is against it; empty if not.
std::string NoteAgainstUser(UpProblem problem, const Reconstruction& reconstruction,
                            const ImageOrientations& orientations, const UpChoice& by_user,
                            double least_odds) {
  constexpr double kElsewhere = 0.9;  // Cosine.
  problem.trust_in_statements = kTrustInSession;
  std::vector<UpView> views;
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    views.push_back(ViewOf(reconstruction.images[i],
                           orientations.empty() ? std::nullopt : orientations[i], std::nullopt,
                           kTrustInSensor));
  }
  problem.views = Thinned(views, kMaxViews);
  const UpChoice without = FindUp(UpEvidence(problem));
  if (without.up_in_world.dot(by_user.up_in_world) > kElsewhere || without.Odds() < least_odds) {
    return "";
  }
  return fmt::format(
      " (look at the map: without --up, another up would be {:.0f} times as likely as the next)",
      without.Odds());
}

}  // namespace

CameraHolds FindCameraHolds(const Reconstruction& reconstruction,
                            const ImageOrientations& orientations,
                            const std::vector<SimilarityProblem::Position>& positions,
                            double normalized_per_world, const GeoregisterOptions& options) {
  if (options.up == UpSource::kPhotos) {
    RequireOrientations(orientations);
  }
  const std::optional<PictureUp> by_user = StatedByUser(options.up);
  const double trust = options.up == UpSource::kPhotos ? kTrustInUser : kTrustInSensor;
  const bool is_given = by_user || options.up == UpSource::kPhotos;
  std::vector<UpView> views;
  bool has_gravity = false;
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    views.push_back(ViewOf(reconstruction.images[i],
                           orientations.empty() ? std::nullopt : orientations[i], by_user, trust));
    has_gravity = has_gravity || views.back().up_in_cam;
  }
  const UpProblem problem = {.views = Thinned(views, kMaxViews),
                             .positions = Thinned(positions, kMaxPositions),
                             .rays_in_world = RaysOf(reconstruction, normalized_per_world),
                             .trust_in_statements = is_given ? 1.0 : kTrustInSession,
                             .roll_sigma_rad = options.upright_sigma_rad};
  const UpEvidence evidence(problem);
  const UpChoice choice = FindUp(evidence);
  double mirror_odds = 0.0;
  if (!is_given) {
    mirror_odds = RequireNoMirror(problem, choice);
    RequireOdds(choice, options);
  }
  CameraHolds holds;
  holds.up_in_world = choice.up_in_world;
  for (const UpView& view : views) {
    holds.of_image.push_back(evidence.HoldOf(view, choice.up_in_world, choice.score));
    ++holds.report.num_images[static_cast<size_t>(holds.of_image.back())];
  }
  holds.report.source = SourceOf(choice, by_user.has_value(), has_gravity);
  if (is_given) {
    holds.report.source +=
        NoteAgainstUser(problem, reconstruction, orientations, choice, options.least_up_odds);
  }
  if (mirror_odds >= options.least_up_odds) {
    holds.report.source += fmt::format(
        "; but a mirrored model, held upright, would be {:.0f} times as likely, if models were "
        "mirrored as often as not: check which way is up, and that letters are not mirrored",
        mirror_odds);
  }
  holds.report.odds = choice.Odds();
  return holds;
}

}  // namespace cairn
