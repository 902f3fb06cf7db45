#include "ingest/place/up_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/angles.h"
#include "core/rotation_between.h"
#include "core/statistics.h"

namespace cairn {
namespace {

// Photos of one walk are alike: the tenth forward view says no more than the first nine. So all
// photos of a session count as this many independent ones.
constexpr double kIndependentViews = 10.0;

// Sine of the pitch of photos that people take: normal about a pitch that the photos of a session
// share, with a share of any pitch.
constexpr double kPitchSigma = 0.2, kWildPitchShare = 0.2;
constexpr double kSharedPitchSigma = 0.25, kMaxSharedPitch = 0.5;
// Rolls beyond the standard deviation of a careful hand.
constexpr double kWildRollShare = 0.1, kWildRollFactor = 3.0;
// The error of a camera that is meant to look straight down.
constexpr double kDownSigmaRad = 0.2;
// The error of an accelerometer in a moving hand, and the share of photos in which it is useless.
constexpr double kGravitySigmaRad = 0.1, kBadGravityShare = 0.1;

// The prior of a session's holds: Dirichlet with these means, in the order of PictureUp, at last
// any other. So weak a prior (half a photo) says that most sessions are of one kind. Cars, robots
// and cameras never stand on their heads, and few people turn a phone so: without further evidence,
// a session of ten lying photos counts as upright.
constexpr HoldShares kHoldPrior = {0.43, 0.37, 0.06, 0.015, 0.04, 0.085};
constexpr double kHoldPriorWeight = 0.5;
constexpr int kShareRounds = 6;

// The shape of a reconstruction drifts by about a hundredth of its extent, so positions that are
// better than that do not make a bend of it significant.
constexpr double kShapeError = 0.01;

// A sight goes far below if it ends this far below the camera, and steeply enough that errors of up
// do not matter. People hold a camera at 1 to 2 m over the ground. On real walks, up to 0.1 % of
// the sights go far below with the true up, and 4 to 45 % with an up that is turned by 90 or 180
// degrees (docs/math/localization.md).
constexpr double kFarBelowM = 3.0, kSteepSine = 0.17;
constexpr double kFewFarBelow = 0.01, kManyFarBelow = 0.04;
// Cameras that look straight down fly: they are rarely so near to what they see.
constexpr double kLeastFlightM = 10.0, kLowFlightShare = 1e-6;
// Share of the sessions that are photographed from bridges, balconies or hills.
constexpr double kHighSessionShare = 0.03;

double Normal(double x, double sigma) {
  const double ratio = x / sigma;
  return std::exp(-0.5 * ratio * ratio) / (sigma * std::sqrt(2.0 * kPi));
}

// Density on the sphere of directions that scatter by `sigma_rad` around one.
double Around(double cosine, double sigma_rad) {
  const double concentration = 1.0 / (sigma_rad * sigma_rad);
  return concentration / (2.0 * kPi) * std::exp(concentration * (cosine - 1.0));
}

double Temper(size_t count) {
  return std::min(1.0, kIndependentViews / std::max(1.0, static_cast<double>(count)));
}

// Minus the logarithm of a Cauchy-like density, as the similarity's loss.
double HalfLoss(double sq_residual) {
  const double sq_scale = kLossScaleSigmas * kLossScaleSigmas;
  return 0.5 * sq_scale * std::log1p(sq_residual / sq_scale);
}

// Probability that a photo was held as `hold`, before its pose is known.
double HoldWeight(const UpView& view, size_t hold, bool with_stated, const HoldShares& shares) {
  if (!with_stated || !view.stated) {
    return shares[hold];
  }
  const double stated = static_cast<size_t>(*view.stated) == hold ? view.trust : 0.0;
  return stated + (1.0 - view.trust) * shares[hold];
}

}  // namespace

UpEvidence::UpEvidence(const UpProblem& problem) : problem_(problem) {
  PreparePositions();
  if (!problem_.sights_in_world.empty()) {
    std::vector<double> lengths;
    for (const Eigen::Vector3d& sight : problem_.sights_in_world) {
      lengths.push_back(sight.norm());
    }
    median_sight_in_world_ = Median(std::move(lengths));
  }
}

// Finds the weights of the positions, and raises their stated accuracies to what they show.
void UpEvidence::PreparePositions() {
  std::vector<SimilarityProblem::Position>& positions = problem_.positions;
  loose_enu_from_world_ = LooseSimilarity(positions);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& position : positions) {
    middle += position.center_in_world / static_cast<double>(positions.size());
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  std::vector<double> distances, sq_residuals;
  for (const auto& position : positions) {
    const Eigen::Vector3d arm = position.center_in_world - middle;
    scatter += arm * arm.transpose();
    distances.push_back(loose_enu_from_world_.scale * arm.norm());
    sq_residuals.push_back(SqResidual(
        position, loose_enu_from_world_ * position.center_in_world - position.center_in_enu));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  line_in_world_ = solver.eigenvectors().col(2);
  constexpr double kMedianSqNormal3 = 2.366;  // Of a chi-squared variable of three dimensions.
  const double excess = std::sqrt(std::max(1.0, Median(sq_residuals) / kMedianSqNormal3));
  const double floor_m = kShapeError * Median(distances);
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i].accuracy_m = std::max(excess * positions[i].accuracy_m, floor_m);
    positions[i].height_accuracy_m = std::max(excess * positions[i].height_accuracy_m, floor_m);
    const double sq = sq_residuals[i] / (excess * excess);
    weights_.push_back(1.0 / (1.0 + sq / (kLossScaleSigmas * kLossScaleSigmas)));
  }
}

double UpEvidence::SharedPitch(const Eigen::Vector3d& up_in_world) const {
  std::vector<double> pitches;
  for (const UpView& view : problem_.views) {
    pitches.push_back((view.cam_from_world * up_in_world).z());
  }
  return std::clamp(Median(std::move(pitches)), -kMaxSharedPitch, kMaxSharedPitch);
}

UpEvidence::Densities UpEvidence::DensitiesOf(const UpView& view,
                                              const Eigen::Vector3d& up_in_world,
                                              double shared_pitch) const {
  const Eigen::Vector3d up_in_cam = view.cam_from_world * up_in_world;
  const double pitch = (1.0 - kWildPitchShare) * Normal(up_in_cam.z() - shared_pitch, kPitchSigma) +
                       0.5 * kWildPitchShare;
  double measured = 1.0;
  if (view.up_in_cam) {
    // Relative to directions without preference, so that views with and without can be mixed.
    measured = kBadGravityShare + (1.0 - kBadGravityShare) * 4.0 * kPi *
                                      Around(up_in_cam.dot(*view.up_in_cam), kGravitySigmaRad);
  }
  Densities densities;
  for (const PictureUp up : kPictureUps) {
    double density = 0.0;
    const double along = up_in_cam.dot(UpInCam(up));
    if (up == PictureUp::kBack) {
      density = Around(along, kDownSigmaRad);
    } else if (along > 0.0) {
      const double roll = up_in_cam.dot(LevelInCam(up));
      density = pitch * ((1.0 - kWildRollShare) * Normal(roll, problem_.roll_sigma_rad) +
                         kWildRollShare * Normal(roll, kWildRollFactor * problem_.roll_sigma_rad));
    }
    densities[static_cast<size_t>(up)] = density * measured;
  }
  densities.back() = measured / (4.0 * kPi);
  return densities;
}

// The evidence with the shares integrated out: the likelihood at their maximum, times what the
// Dirichlet prior leaves of it. `shares` receives the maximum.
double UpEvidence::ScoreHolds(const std::vector<Densities>& densities, bool with_stated,
                              HoldShares* shares) const {
  const double temper = Temper(densities.size());
  *shares = kHoldPrior;
  HoldShares counts = {};
  double log_likelihood = 0.0;
  for (int round = 0; round < kShareRounds; ++round) {
    counts.fill(0.0);
    log_likelihood = 0.0;
    double free_views = 0.0;  // Whose hold is drawn from the shares.
    for (size_t i = 0; i < densities.size(); ++i) {
      const UpView& view = problem_.views[i];
      double sum = 0.0;
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        sum += HoldWeight(view, hold, with_stated, *shares) * densities[i][hold];
      }
      log_likelihood += temper * std::log(sum);
      const double own = with_stated && view.stated ? 1.0 - view.trust : 1.0;
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        const double count = temper * own * (*shares)[hold] * densities[i][hold] / sum;
        counts[hold] += count;
        free_views += count;
      }
    }
    if (round + 1 < kShareRounds) {
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        (*shares)[hold] =
            (counts[hold] + kHoldPriorWeight * kHoldPrior[hold]) / (free_views + kHoldPriorWeight);
      }
    }
  }
  double occam = std::lgamma(kHoldPriorWeight);
  double total = 0.0;
  for (size_t hold = 0; hold < shares->size(); ++hold) {
    const double prior = kHoldPriorWeight * kHoldPrior[hold];
    occam += std::lgamma(counts[hold] + prior) - std::lgamma(prior) -
             counts[hold] * std::log((*shares)[hold]);
    total += counts[hold];
  }
  occam -= std::lgamma(total + kHoldPriorWeight);
  return log_likelihood + occam;
}

// Fits yaw, scale and place in closed form. For the horizontal coordinates as complex numbers e of
// the positions and p of the centers, and the heights h and v, all relative to their weighted
// means, the yaw is the argument of sum(e conj(p)), and the scale is (|sum(e conj(p))| + sum(h v))
// / (sum |p|^2 + sum v^2).
double UpEvidence::ScorePositions(const Eigen::Vector3d& up_in_world, double* enu_per_world) const {
  const auto& positions = problem_.positions;
  const Eigen::Quaterniond level_from_world =
      RotationBetween(up_in_world, Eigen::Vector3d::UnitZ());
  std::vector<Eigen::Vector3d> level(positions.size());
  Eigen::Vector3d level_mean = Eigen::Vector3d::Zero(), enu_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d weight_sum = Eigen::Vector3d::Zero();
  const auto weight_of = [&](size_t i) {
    const double flat = weights_[i] / (positions[i].accuracy_m * positions[i].accuracy_m);
    return Eigen::Vector3d(
        flat, flat,
        weights_[i] / (positions[i].height_accuracy_m * positions[i].height_accuracy_m));
  };
  for (size_t i = 0; i < positions.size(); ++i) {
    level[i] = level_from_world * positions[i].center_in_world;
    const Eigen::Vector3d weight = weight_of(i);
    level_mean += weight.cwiseProduct(level[i]);
    enu_mean += weight.cwiseProduct(positions[i].center_in_enu);
    weight_sum += weight;
  }
  level_mean = level_mean.cwiseQuotient(weight_sum);
  enu_mean = enu_mean.cwiseQuotient(weight_sum);
  std::complex<double> turn = 0.0;
  double numerator = 0.0, denominator = 0.0;
  for (size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d p = level[i] - level_mean;
    const Eigen::Vector3d e = positions[i].center_in_enu - enu_mean;
    const Eigen::Vector3d weight = weight_of(i);
    turn += weight.x() * std::complex<double>(e.x(), e.y()) * std::complex<double>(p.x(), -p.y());
    numerator += weight.z() * e.z() * p.z();
    denominator += weight.x() * p.head<2>().squaredNorm() + weight.z() * p.z() * p.z();
  }
  const double scale = std::max(0.0, (std::abs(turn) + numerator) / denominator);
  const Eigen::AngleAxisd yaw(std::arg(turn), Eigen::Vector3d::UnitZ());
  double loss = 0.0;
  for (size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d error =
        scale * (yaw * (level[i] - level_mean)) - (positions[i].center_in_enu - enu_mean);
    loss += HalfLoss(SqResidual(positions[i], error));
  }
  *enu_per_world = scale;
  return -Temper(positions.size()) * loss;
}

double UpEvidence::ScoreGround(const Eigen::Vector3d& up_in_world, double enu_per_world) const {
  if (problem_.sights_in_world.empty()) {
    return 0.0;
  }
  int64_t num_far_below = 0;
  for (const Eigen::Vector3d& sight : problem_.sights_in_world) {
    const double up = sight.dot(up_in_world);
    num_far_below += enu_per_world * up < -kFarBelowM && up < -kSteepSine * sight.norm();
  }
  const double share =
      static_cast<double>(num_far_below) / static_cast<double>(problem_.sights_in_world.size());
  return std::log(kHighSessionShare) *
         std::clamp((share - kFewFarBelow) / (kManyFarBelow - kFewFarBelow), 0.0, 1.0);
}

double UpEvidence::ScoreFlight(double enu_per_world) const {
  const bool is_low =
      median_sight_in_world_ > 0.0 && enu_per_world * median_sight_in_world_ < kLeastFlightM;
  return is_low ? std::log(kLowFlightShare) : 0.0;
}

UpScore UpEvidence::Score(const Eigen::Vector3d& up_in_world) const {
  std::vector<Densities> densities;
  bool has_stated = false;
  const double shared_pitch = SharedPitch(up_in_world);
  for (const UpView& view : problem_.views) {
    densities.push_back(DensitiesOf(view, up_in_world, shared_pitch));
    has_stated = has_stated || view.stated;
  }
  UpScore score;
  score.cameras = ScoreHolds(densities, /*with_stated=*/false, &score.shares);
  if (has_stated) {
    score.stated = ScoreHolds(densities, /*with_stated=*/true, &score.shares) - score.cameras;
  }
  double enu_per_world = 0.0;
  score.positions = ScorePositions(up_in_world, &enu_per_world);
  // Cameras that look straight down hang high, and share no pitch.
  const double share_ahead = 1.0 - score.shares[static_cast<size_t>(PictureUp::kBack)];
  const double pitch_sigmas = shared_pitch / kSharedPitchSigma;
  score.cameras -= share_ahead * 0.5 * pitch_sigmas * pitch_sigmas;
  score.ground = share_ahead * ScoreGround(up_in_world, enu_per_world) +
                 (1.0 - share_ahead) * ScoreFlight(enu_per_world);
  return score;
}

PictureUp UpEvidence::HoldOf(const UpView& view, const Eigen::Vector3d& up_in_world,
                             const HoldShares& shares) const {
  const Densities densities = DensitiesOf(view, up_in_world, SharedPitch(up_in_world));
  PictureUp best = PictureUp::kTop;
  double best_weight = -1.0;
  for (const PictureUp up : kPictureUps) {
    const size_t hold = static_cast<size_t>(up);
    const double weight = HoldWeight(view, hold, true, shares) * densities[hold];
    if (weight > best_weight) {
      best = up;
      best_weight = weight;
    }
  }
  return best;
}

}  // namespace cairn
