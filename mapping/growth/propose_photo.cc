#include "mapping/growth/propose_photo.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/focal_length.h"
#include "core/random.h"
#include "core/rotation_between.h"

namespace cairn {
namespace {

// Focal lengths, relative to the known one, that a photo of a new camera is tried with beside it.
constexpr double kGuessedFactors[] = {0.8, 1.25, 0.64, 1.5625, 1.95, 2.44, 3.05};
constexpr double kToldFactors[] = {0.87, 1.15};

std::span<const double> FactorsOfNew(FocalSource source) {
  switch (source) {
    case FocalSource::kGuess:
      return kGuessedFactors;
    case FocalSource::kPhotos:
      return kToldFactors;
    case FocalSource::kCalibration:
    case FocalSource::kExif:
    case FocalSource::kGrowth:
      break;
  }
  return {};
}

// SIFT still matches most of what two photos show if their directions differ by less (Mikolajczyk
// and Schmid 2005), and if one shows it less than this many times as large.
constexpr double kAlikeAngleRad = 0.35;
constexpr double kAlikeScale = 2.0;
// A link is strong with this share of the inliers of a photo's strongest link.
constexpr double kStrongLinkShare = 0.5;
// The two views that agree have this many times the inliers of those that contradict.
constexpr double kBeyondDoubt = 4.0;
// Two photos are of the same picture if most of what both show is at the same place of both, up to
// this share of their longer sides.
constexpr double kSamePlaceShare = 0.01;
constexpr size_t kMaxElsewhereInTen = 1;

// True if two cameras see most of the points, from nearly the same direction and as large.
bool LooksAlike(const Rigid3d& p_from_world, const Camera& camera_p, const Rigid3d& q_from_world,
                const Camera& camera_q, const std::vector<Eigen::Vector3d>& points_in_world) {
  const Eigen::Vector3d p = p_from_world.Inverse().translation;
  const Eigen::Vector3d q = q_from_world.Inverse().translation;
  size_t num_alike = 0;
  for (const Eigen::Vector3d& x : points_in_world) {
    const auto pixel = camera_q.Project(q_from_world * x);
    if (!pixel || !camera_q.Contains(*pixel)) {
      continue;
    }
    const Eigen::Vector3d from_p = x - p, from_q = x - q;
    const double angle = AngleBetweenRad(from_p, from_q);
    const double scale =
        camera_p.focal_px() * from_q.norm() / (camera_q.focal_px() * from_p.norm());
    num_alike += angle < kAlikeAngleRad && scale < kAlikeScale && scale > 1.0 / kAlikeScale ? 1 : 0;
  }
  return 2 * num_alike > points_in_world.size();
}

}  // namespace

Testimony Proposer::AskAbout(const Draft& draft, int photo, const Posed& posed) const {
  return graph_.Ask(photo, posed, [&](int other) {
    return other != photo && draft.Has(other)
               ? std::optional<Posed>({draft.PoseOf(other), draft.CameraOf(other)})
               : std::nullopt;
  });
}

bool Proposer::IsElsewhere(const Draft& draft, const GpsCheck& gps, const Testimony& testimony,
                           int photo, const Rigid3d& cam_from_world) const {
  const bool is_doubted =
      kBeyondDoubt * testimony.contradicting_inliers > testimony.agreeing_inliers;
  return gps.Contradicts(photo, cam_from_world, is_doubted) &&
         !IsPositionWrong(draft, gps, testimony, photo, cam_from_world);
}

bool Proposer::IsPositionWrong(const Draft& draft, const GpsCheck& gps, const Testimony& testimony,
                               int photo, const Rigid3d& cam_from_world) const {
  if (!IsBeyondDoubt(testimony)) {
    return false;
  }
  double near_pose = 0.0, near_position = 0.0;  // Inliers.
  double strongest = 0.0, strongest_in_draft = 0.0, strongest_near_position = 0.0;
  for (const int view : graph_.ViewsOf(photo)) {
    const int other = graph_.OtherOf(view, photo);
    const auto num_inliers = static_cast<double>(graph_.View(view).inliers.size());
    strongest = std::max(strongest, num_inliers);
    const GpsCheck::Nearer nearer = gps.NearerTo(other, photo, cam_from_world);
    if (nearer == GpsCheck::Nearer::kPosition) {
      near_position += num_inliers;
      strongest_near_position = std::max(strongest_near_position, num_inliers);
    } else if (draft.Has(other)) {
      near_pose += nearer == GpsCheck::Nearer::kPose ? num_inliers : 0.0;
      strongest_in_draft = std::max(strongest_in_draft, num_inliers);
    }
  }
  return near_pose > 0.0 && near_pose >= kBeyondDoubt * near_position &&
         strongest_in_draft >= kStrongLinkShare * strongest &&
         strongest_near_position < kStrongLinkShare * strongest;
}

Proposal Proposer::Localize(const Draft& draft, int photo) const {
  Proposal proposal;
  proposal.photo = photo;
  const std::vector<LandmarkObservation> observations = draft.ObservationsOf(photo);
  proposal.num_observations = static_cast<int>(observations.size());
  const int camera_idx = set_.photos[photo].camera_idx;
  const Camera& camera = draft.CameraOf(photo);
  std::vector<Camera> cameras = {camera};
  if (draft.IsNewCamera(camera_idx)) {
    for (const double factor : FactorsOfNew(set_.cameras[camera_idx].Certainty())) {
      cameras.push_back(WithFocalScaled(camera, factor));
    }
  }
  proposal.pose =
      LocalizePhoto(cameras, observations, options_.min_inliers, SeedOf(photo, draft.num_photos()));
  if (proposal.pose && draft.IsNewCamera(camera_idx) && set_.cameras[camera_idx].may_be_cropped) {
    FitPart(set_.cameras[camera_idx], observations, &*proposal.pose);
  }
  return proposal;
}

Proposal Proposer::Propose(const Draft& draft, const GpsCheck& gps, int photo,
                           bool is_last_resort) const {
  Proposal proposal = Localize(draft, photo);
  if (!proposal.pose) {
    return proposal;
  }
  const Testimony testimony =
      AskAbout(draft, photo, {proposal.pose->cam_from_world, proposal.pose->camera});
  if (proposal.pose->num_inliers < options_.min_link_share * StrongestLinkOutside(draft, photo) &&
      !(is_last_resort && IsBeyondDoubt(testimony) &&
        !LooksLikeOneOf(draft, photo, *proposal.pose))) {
    proposal.verdict = PhotoVerdict::kWeakSupport;
  } else if (testimony.num_witnesses < options_.min_witnesses ||
             testimony.agreeing_inliers <= testimony.contradicting_inliers) {
    proposal.verdict = PhotoVerdict::kContradicted;
  } else if (IsElsewhere(draft, gps, testimony, photo, proposal.pose->cam_from_world)) {
    proposal.verdict = PhotoVerdict::kGpsContradicts;
  } else {
    proposal.verdict = PhotoVerdict::kInSegment;
  }
  return proposal;
}

bool Proposer::IsBeyondDoubt(const Testimony& testimony) const {
  return testimony.num_witnesses > options_.min_witnesses &&
         testimony.agreeing_inliers >= kBeyondDoubt * testimony.contradicting_inliers;
}

bool Proposer::LooksLikeOneOf(const Draft& draft, int photo, const LocalizedPhoto& pose) const {
  const std::vector<LandmarkObservation> observations = draft.ObservationsOf(photo);
  std::vector<Eigen::Vector3d> seen;
  for (const LandmarkObservation& observation : observations) {
    const auto pixel = pose.camera.Project(pose.cam_from_world * observation.x_in_world);
    if (pixel && (*pixel - observation.pixel).norm() <= kMaxDraftSigmas * observation.SigmaPx()) {
      seen.push_back(observation.x_in_world);
    }
  }
  return std::any_of(draft.photos().begin(), draft.photos().end(), [&](int other) {
    return LooksAlike(pose.cam_from_world, pose.camera, draft.PoseOf(other), draft.CameraOf(other),
                      seen);
  });
}

bool Proposer::IsSamePicture(const TwoView& view) const {
  const MappingPhoto& a = set_.photos[view.a];
  const MappingPhoto& b = set_.photos[view.b];
  const Camera& camera_a = set_.cameras[a.camera_idx].camera;
  const Camera& camera_b = set_.cameras[b.camera_idx].camera;
  const double b_from_a = static_cast<double>(std::max(camera_b.width_px(), camera_b.height_px())) /
                          std::max(camera_a.width_px(), camera_a.height_px());
  const double limit_px = kSamePlaceShare * std::max(camera_b.width_px(), camera_b.height_px());
  size_t num_elsewhere = 0;
  for (const FeatureMatch& match : view.inliers) {
    const Keypoint& p = a.keypoints[match.a_idx];
    const Keypoint& q = b.keypoints[match.b_idx];
    num_elsewhere +=
        std::hypot(b_from_a * p.x_px - q.x_px, b_from_a * p.y_px - q.y_px) > limit_px ? 1 : 0;
    if (10 * num_elsewhere > kMaxElsewhereInTen * view.inliers.size()) {
      return false;
    }
  }
  return true;
}

int Proposer::StrongestLinkOutside(const Draft& draft, int photo) const {
  size_t strongest = 0;
  for (const int view : graph_.ViewsOf(photo)) {
    if (!draft.Has(graph_.OtherOf(view, photo)) && !IsSamePicture(graph_.View(view))) {
      strongest = std::max(strongest, graph_.View(view).inliers.size());
    }
  }
  return static_cast<int>(strongest);
}

uint64_t Proposer::SeedOf(int photo, int num_photos) const {
  return HashWord(options_.seed ^
                  HashWord(static_cast<uint64_t>(photo) << 32 | static_cast<uint64_t>(num_photos)));
}

}  // namespace cairn
