#include "mapping/growth/gps_check.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "core/geodesy.h"
#include "core/radius68.h"
#include "core/random.h"
#include "core/statistics.h"

namespace cairn {
namespace {

// A position counts for the fit up to this many standard deviations, and is contradicted beyond the
// second number: of normal errors, 1 in 500 without the drift, 1 in 5,000 with it.
constexpr double kMaxFitSigmas = 3.0;
constexpr double kMaxSigmas = 3.5;
// Two views that contradict are rare, and so are positions that err by this much (1 in 20): both at
// once are a copy.
constexpr double kMaxSigmasOfDoubted = 2.5;
// The fit must know scale and turn of a draft as well as this to tell where it is (as
// georegistration asks).
constexpr double kMaxTurnRad = 0.25;
// The same to contradict a photo: near the fitted photos, a fit is better than far away, and
// Contradicts() allows for that.
constexpr double kMaxTurnToContradictRad = 0.5;
// What a draft that was never adjusted with positions bends: KITTI's second drive with a guessed
// focal length was 0.9 m off within 50 m. The repetitions of facades that matter are meters.
constexpr double kDriftM = 2.0;
constexpr double kDriftShare = 0.02;  // Of the distance from the middle.
// Fewer positions than this are fitted all together: of few, three always fit by chance.
constexpr int kMinForConsensus = 10;
constexpr int kNumSamples = 200;
// Of two copies, one has at least half of the photos. The fit to them has the least such quantile
// of errors; the median would reach into the other copy if both have as many.
constexpr double kFitQuantile = 0.45;
// The noise is told by this quantile of the errors: more photos than this are at the right copy.
constexpr double kNoiseQuantile = 0.3;
constexpr double kNoiseQuantileSigmas = 0.8446;  // Of a normal error in the plane.
// Positions that state no accuracy are believed to err this share of the default at least.
constexpr double kLeastNoiseOfUnstated = 1.0 / 3.0;

// Photos before and after a step whose mean errors are compared. More would average over the bends
// of a draft, and fewer do not tell a step from noise.
constexpr int kMaxStepPhotos = 6;
constexpr int kMinStepPhotos = 3;
// A step is no chance beyond this many of its standard deviations: each photo is asked, and the
// errors of a receiver are not all independent.
constexpr double kMaxStepSigmas = 4.5;

struct Fix {
  int photo = 0;
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_enu;
  double sigma_m = 0.0;  // As stated, an axis.
  bool is_stated = false;
};

Sim3d FitSimilarity(const std::vector<Fix>& fixes) {
  Eigen::Matrix3Xd world(3, fixes.size()), enu(3, fixes.size());
  for (size_t i = 0; i < fixes.size(); ++i) {
    world.col(i) = fixes[i].in_world;
    enu.col(i) = fixes[i].in_enu;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(world, enu, true);
  Sim3d similarity;
  similarity.scale = std::cbrt(fit.topLeftCorner<3, 3>().determinant());
  similarity.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(fit.topLeftCorner<3, 3>() / similarity.scale));
  similarity.translation = fit.topRightCorner<3, 1>();
  return similarity;
}

bool IsFit(const Sim3d& fit) { return fit.scale > 0.0 && std::isfinite(fit.translation.sum()); }

std::vector<double> ErrorsInSigmas(const std::vector<Fix>& fixes, const Sim3d& enu_from_world) {
  std::vector<double> errors;
  for (const Fix& fix : fixes) {
    const Eigen::Vector3d error = enu_from_world * fix.in_world - fix.in_enu;
    errors.push_back(error.head<2>().norm() / fix.sigma_m);
  }
  return errors;
}

// The similarity with the least quantile of errors, by that of all fixes and those of random
// triples.
Sim3d FitHalf(const std::vector<Fix>& fixes, uint64_t seed) {
  Sim3d best = FitSimilarity(fixes);
  if (static_cast<int>(fixes.size()) < kMinForConsensus) {
    return best;
  }
  double least = IsFit(best) ? ValueAtShare(ErrorsInSigmas(fixes, best), kFitQuantile)
                             : std::numeric_limits<double>::infinity();
  Random random(seed);
  const int count = static_cast<int>(fixes.size());
  for (int i = 0; i < kNumSamples; ++i) {
    const int p = random.Index(count), q = random.Index(count), r = random.Index(count);
    if (p == q || q == r || p == r) {
      continue;
    }
    const Sim3d fit = FitSimilarity({fixes[p], fixes[q], fixes[r]});
    if (!IsFit(fit)) {
      continue;
    }
    const double error = ValueAtShare(ErrorsInSigmas(fixes, fit), kFitQuantile);
    if (error < least) {
      least = error;
      best = fit;
    }
  }
  return best;
}

double NoiseOf(const Fix& fix, double of_stated, double of_unstated) {
  return fix.is_stated ? of_stated : of_unstated;
}

std::vector<Fix> FixesOf(const PhotoSet& set, const Draft& draft, double default_accuracy_m) {
  std::vector<Fix> fixes;
  for (const int photo : draft.photos()) {
    const MappingPhoto& source = set.photos[photo];
    if (source.gps && source.gps_has_height) {
      fixes.push_back({photo, draft.PoseOf(photo).Inverse().translation,
                       EcefFromGeodetic(*source.gps),
                       source.gps_accuracy_m.value_or(default_accuracy_m) / kRadius68PerSigma2d,
                       source.gps_accuracy_m.has_value()});
    }
  }
  return fixes;
}

// The mean and the principal axis of the photos. Sets their root mean square distance from it.
Eigen::ParametrizedLine<double, 3> FitLine(const std::vector<Fix>& fixes,
                                           const Sim3d& enu_from_world, double* across_m) {
  const double count = static_cast<double>(fixes.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Fix& fix : fixes) {
    mean += enu_from_world * fix.in_world / count;
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Fix& fix : fixes) {
    const Eigen::Vector3d offset = enu_from_world * fix.in_world - mean;
    scatter += offset * offset.transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);  // Ascending.
  *across_m = std::sqrt(std::max(0.0, solver.eigenvalues().head<2>().sum()));
  return {mean, solver.eigenvectors().col(2)};
}

}  // namespace

GpsCheck::GpsCheck(const PhotoSet& set, const Draft& draft, double default_accuracy_m,
                   uint64_t seed)
    : set_(set), default_accuracy_m_(default_accuracy_m) {
  std::vector<Fix> fixes = FixesOf(set, draft, default_accuracy_m);  // In ECEF at first.
  if (static_cast<int>(fixes.size()) < kMinPositions) {
    return;
  }
  enu_from_ecef_ = EcefFromEnu(GeodeticFromEcef(fixes.front().in_enu)).Inverse();
  for (Fix& fix : fixes) {
    fix.in_enu = enu_from_ecef_ * fix.in_enu;
  }
  Sim3d fit = FitHalf(fixes, seed);
  std::vector<Fix> kept;
  for (int round = 0; round < 3 && IsFit(fit); ++round) {
    const std::vector<double> errors = ErrorsInSigmas(fixes, fit);
    const double noise = ValueAtShare(errors, kNoiseQuantile) / kNoiseQuantileSigmas;
    noise_of_stated_ = std::max(1.0, noise);
    noise_of_unstated_ = static_cast<int>(fixes.size()) < kMinForConsensus
                             ? noise_of_stated_
                             : std::max(kLeastNoiseOfUnstated, noise);
    kept.clear();
    for (size_t i = 0; i < fixes.size(); ++i) {
      if (errors[i] <= kMaxFitSigmas * NoiseOf(fixes[i], noise_of_stated_, noise_of_unstated_)) {
        kept.push_back(fixes[i]);
      }
    }
    if (static_cast<int>(kept.size()) < kMinPositions) {
      return;
    }
    fit = FitSimilarity(kept);
  }
  if (kept.empty()) {
    return;  // There is no fit: the positions are all the same.
  }
  const double count = static_cast<double>(kept.size());
  std::vector<double> sigmas_m;
  for (const Fix& fix : kept) {
    middle_in_enu_ += fix.in_enu.head<2>() / count;
    sigmas_m.push_back(fix.sigma_m * NoiseOf(fix, noise_of_stated_, noise_of_unstated_));
  }
  for (const Fix& fix : kept) {
    spread_m_ += (fix.in_enu.head<2>() - middle_in_enu_).squaredNorm() / count;
  }
  spread_m_ = std::sqrt(spread_m_);
  fit_sigma_m_ = Median(std::move(sigmas_m)) / std::sqrt(count);
  if (IsFit(fit) && fit_sigma_m_ <= kMaxTurnToContradictRad * spread_m_) {
    enu_from_world_ = fit;
    line_in_enu_ = FitLine(kept, fit, &across_m_);
    for (const Fix& fix : fixes) {
      misses_.push_back({fix.photo, (fit * fix.in_world - fix.in_enu).head<2>(),
                         fix.in_enu.head<2>(),
                         fix.sigma_m * NoiseOf(fix, 1.0, noise_of_unstated_)});
    }
    std::sort(misses_.begin(), misses_.end(),
              [](const Miss& p, const Miss& q) { return p.photo < q.photo; });
  }
}

bool GpsCheck::KnowsPlace() const {
  return enu_from_world_ && fit_sigma_m_ <= kMaxTurnRad * spread_m_;
}

double GpsCheck::NoiseOfRow() const {
  std::vector<double> changes;
  for (size_t i = 1; i < misses_.size(); ++i) {
    changes.push_back((misses_[i].error_m - misses_[i - 1].error_m).norm());
  }
  // The median of a difference in the plane, and what chance adds to that of a few: one standard
  // deviation of the median.
  constexpr double kMedianSigmas = 1.1774 * std::numbers::sqrt2;
  const double chance = 1.0 + 1.2 / std::sqrt(static_cast<double>(changes.size()));
  return Median(std::move(changes)) / (kMedianSigmas * chance);
}

std::vector<GpsCheck::Miss> GpsCheck::UsualOf(const std::vector<Miss>& misses, double noise_m) {
  const auto median_of = [&](int axis) {
    std::vector<double> errors_m;
    for (const Miss& miss : misses) {
      errors_m.push_back(miss.error_m[axis]);
    }
    return Median(std::move(errors_m));
  };
  const Eigen::Vector2d median_m(median_of(0), median_of(1));
  std::vector<Miss> usual;
  std::copy_if(misses.begin(), misses.end(), std::back_inserter(usual), [&](const Miss& miss) {
    return (miss.error_m - median_m).norm() <=
           kMaxStepSigmas * std::max(noise_m, miss.sigma_m) + kDriftM;
  });
  return usual;
}

double GpsCheck::StepShare(const std::vector<Miss>& before, const std::vector<Miss>& after,
                           double noise_m) const {
  Eigen::Vector2d step_m = Eigen::Vector2d::Zero(), way_m = Eigen::Vector2d::Zero();
  double sq_sigma_m = 0.0;
  for (const auto& [misses, sign] : {std::pair(&before, -1.0), std::pair(&after, 1.0)}) {
    const double share = sign / static_cast<double>(misses->size());
    for (const Miss& miss : *misses) {
      step_m += share * miss.error_m;
      way_m += share * miss.in_enu;
      sq_sigma_m += std::pow(share * std::max(noise_m, miss.sigma_m), 2);
    }
  }
  return step_m.norm() /
         (kMaxStepSigmas * std::sqrt(sq_sigma_m) + kDriftM + kDriftShare * way_m.norm());
}

std::vector<int> GpsCheck::BeyondStep() const {
  const int count = static_cast<int>(misses_.size());
  if (count < 2 * kMinStepPhotos || !KnowsPlace()) {
    return {};
  }
  const double noise_m = NoiseOfRow();
  int worst = -1;
  double most = 0.0;
  for (int i = kMinStepPhotos; i + kMinStepPhotos <= count; ++i) {
    const auto middle = misses_.begin() + i;
    const std::vector<Miss> before(middle - std::min(i, kMaxStepPhotos), middle);
    const std::vector<Miss> after(middle, middle + std::min(count - i, kMaxStepPhotos));
    const std::vector<Miss> usual_before = UsualOf(before, noise_m);
    const std::vector<Miss> usual_after = UsualOf(after, noise_m);
    // Beside a step, the usual misses are those of one copy; all of them tell where it is.
    const double share = StepShare(before, after, noise_m);
    if (share > most && static_cast<int>(usual_before.size()) >= kMinStepPhotos &&
        static_cast<int>(usual_after.size()) >= kMinStepPhotos &&
        StepShare(usual_before, usual_after, noise_m) > 1.0) {
      most = share;
      worst = i;
    }
  }
  std::vector<int> photos;
  if (worst >= 0) {
    const bool is_before = 2 * worst < count;
    for (int i = is_before ? 0 : worst; i < (is_before ? worst : count); ++i) {
      photos.push_back(misses_[i].photo);
    }
  }
  return photos;
}

double GpsCheck::SigmaOf(const MappingPhoto& photo) const {
  const double stated_m = photo.gps_accuracy_m.value_or(default_accuracy_m_) / kRadius68PerSigma2d;
  return stated_m * (photo.gps_accuracy_m ? noise_of_stated_ : noise_of_unstated_);
}

Eigen::Vector2d GpsCheck::PositionInEnu(int photo) const {
  return (enu_from_ecef_ * EcefFromGeodetic(*set_.photos[photo].gps)).head<2>();
}

Eigen::Vector2d GpsCheck::PoseInEnu(const Rigid3d& cam_from_world) const {
  return (*enu_from_world_ * cam_from_world.Inverse().translation).head<2>();
}

double GpsCheck::TurnErrorM(const Eigen::Vector3d& x_in_enu) const {
  constexpr double kHalfTurn = 2.0;  // Moves a point by twice its distance from the line.
  const double turn = kMaxSigmas * fit_sigma_m_ / std::max(1e-9, across_m_);
  return line_in_enu_.distance(x_in_enu) * std::min(kHalfTurn, turn);
}

GpsCheck::Nearer GpsCheck::NearerTo(int witness, int photo, const Rigid3d& cam_from_world) const {
  if (!enu_from_world_ || !set_.photos[witness].gps || !set_.photos[photo].gps) {
    return Nearer::kNeither;
  }
  const Eigen::Vector2d of_witness = PositionInEnu(witness);
  const double to_pose_m = (of_witness - PoseInEnu(cam_from_world)).norm();
  const double to_position_m = (of_witness - PositionInEnu(photo)).norm();
  if (2.0 * to_pose_m <= to_position_m) {
    return Nearer::kPose;
  }
  return 2.0 * to_position_m <= to_pose_m ? Nearer::kPosition : Nearer::kNeither;
}

bool GpsCheck::Contradicts(int photo, const Rigid3d& cam_from_world, bool is_doubted) const {
  const MappingPhoto& source = set_.photos[photo];
  if (!enu_from_world_ || !source.gps || !source.gps_has_height) {
    return false;
  }
  const Eigen::Vector3d found = *enu_from_world_ * cam_from_world.Inverse().translation;
  // The error of a fitted line: that of its middle, and that of its turn and scale.
  const double distance_m = (found.head<2>() - middle_in_enu_).norm();
  const double fit_sigma_m = fit_sigma_m_ * std::hypot(1.0, distance_m / spread_m_);
  const double max_sigmas = is_doubted ? kMaxSigmasOfDoubted : kMaxSigmas;
  const double limit_m = max_sigmas * std::hypot(SigmaOf(source), fit_sigma_m) + kDriftM +
                         kDriftShare * distance_m + TurnErrorM(found);
  return (found.head<2>() - PositionInEnu(photo)).norm() > limit_m;
}

}  // namespace cairn
