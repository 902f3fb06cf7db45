#include "ingest/place/up_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "core/angles.h"
#include "core/rotation_between.h"
#include "core/statistics.h"
#include "ingest/place/up_priors.h"

namespace cairn {
namespace {

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

double LogOfSum(double a, double b) {
  const double larger = std::max(a, b);
  return larger + std::log(std::exp(a - larger) + std::exp(b - larger));
}

// Probability that a sensor or a user states what it does of a photo that was held as `hold`.
double StatementLikelihood(const UpView& view, size_t hold) {
  constexpr double kAny = 0.25;
  if (!view.stated || (!view.is_by_user && hold >= static_cast<size_t>(PictureUp::kBack))) {
    return view.stated ? kAny : 1.0;
  }
  const bool is_same = static_cast<size_t>(*view.stated) == hold;
  return (is_same ? view.trust : 0.0) + (1.0 - view.trust) * kAny;
}

}  // namespace

UpEvidence::UpEvidence(const UpProblem& problem) : problem_(problem) {
  PreparePositions();
  PrepareStatements();
  if (!problem_.rays_in_world.empty()) {
    std::vector<double> lengths;
    for (const Eigen::Vector3d& ray : problem_.rays_in_world) {
      lengths.push_back(ray.norm());
    }
    std::sort(lengths.begin(), lengths.end());
    near_ray_in_world_ = lengths[lengths.size() / 10];
    far_ray_in_world_ = lengths[lengths.size() - 1 - lengths.size() / 10];
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

void UpEvidence::PrepareStatements() {
  std::optional<PictureUp> first;
  bool is_mixed = false;
  for (const UpView& view : problem_.views) {
    if (view.stated) {
      is_mixed = is_mixed || *view.stated != first.value_or(*view.stated);
      first = view.stated;
    }
  }
  has_stated_ = first.has_value();
  if (has_stated_) {
    made_up_ = is_mixed ? kMadeUpMixed : kMadeUp[static_cast<size_t>(*first)];
    said_from_above_ = is_mixed ? kSaidFromAboveMixed : kSaidFromAbove[static_cast<size_t>(*first)];
  }
  if (has_stated_ && problem_.views.front().is_by_user) {  // Then all of them are.
    said_from_above_ = 0.0;
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
      const double roll = std::atan2(up_in_cam.dot(LevelInCam(up)), along);
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
double UpEvidence::ScoreHolds(const std::vector<Densities>& densities, HoldShares* shares) {
  const double temper = Temper(densities.size());
  *shares = kHoldPrior;
  HoldShares counts = {};
  double log_likelihood = 0.0;
  for (int round = 0; round < kShareRounds; ++round) {
    counts.fill(0.0);
    log_likelihood = 0.0;
    for (const Densities& of_view : densities) {
      double sum = 0.0;
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        sum += (*shares)[hold] * of_view[hold];
      }
      log_likelihood += temper * std::log(sum);
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        counts[hold] += temper * (*shares)[hold] * of_view[hold] / sum;
      }
    }
    if (round + 1 < kShareRounds) {
      for (size_t hold = 0; hold < shares->size(); ++hold) {
        (*shares)[hold] = (counts[hold] + kHoldPriorWeight * kHoldPrior[hold]) /
                          (temper * static_cast<double>(densities.size()) + kHoldPriorWeight);
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

// Either a sensor wrote the orientations of a session, or they say nothing of any of its photos.
void UpEvidence::ScoreStatements(std::vector<Densities> densities, UpScore* score) const {
  for (size_t i = 0; i < densities.size(); ++i) {
    for (size_t hold = 0; hold < densities[i].size(); ++hold) {
      densities[i][hold] *= StatementLikelihood(problem_.views[i], hold);
    }
  }
  HoldShares shares = {};
  const double trust = problem_.trust_in_statements;
  const double by_sensor = std::log(trust) + ScoreHolds(densities, &shares);
  const double share_down = score->shares[static_cast<size_t>(PictureUp::kBack)];
  const double by_nothing =
      std::log((1.0 - trust) * made_up_ + trust * share_down * said_from_above_) + score->cameras;
  score->stated = LogOfSum(by_sensor, by_nothing) - score->cameras;
  score->heeds_statements = by_sensor > by_nothing;
  if (score->heeds_statements) {
    score->shares = shares;
  }
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
    const double flat_m = positions[i].accuracy_m, height_m = positions[i].height_accuracy_m;
    const double flat = weights_[i] / (flat_m * flat_m);
    return Eigen::Vector3d(flat, flat, weights_[i] / (height_m * height_m));
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
  double sq_climbs = 0.0, sq_distances = 0.0;
  for (size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d p = level[i] - level_mean;
    const Eigen::Vector3d e = positions[i].center_in_enu - enu_mean;
    const Eigen::Vector3d weight = weight_of(i);
    turn += weight.x() * std::complex<double>(e.x(), e.y()) * std::complex<double>(p.x(), -p.y());
    numerator += weight.z() * e.z() * p.z();
    denominator += weight.x() * p.head<2>().squaredNorm() + weight.z() * p.z() * p.z();
    sq_climbs += p.z() * p.z();
    sq_distances += p.head<2>().squaredNorm();
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
  const double sq_slope_sigmas =
      sq_climbs / std::max(1e-12, sq_distances) / (kSlopeSigma * kSlopeSigma);
  const double log_slope =
      std::log((1.0 - kClimbShare) * std::exp(-0.5 * sq_slope_sigmas) + kClimbShare);
  return log_slope - Temper(positions.size()) * loss;
}

// An upside-down street is a street under a low roof: nothing goes far above.
double UpEvidence::ScoreGround(const Eigen::Vector3d& up_in_world, double enu_per_world) const {
  if (problem_.rays_in_world.empty()) {
    return 0.0;
  }
  int64_t num_far_below = 0, num_far_above = 0, num_roof = 0;
  for (const Eigen::Vector3d& ray : problem_.rays_in_world) {
    const double up = ray.dot(up_in_world);
    if (std::abs(up) > kSteepSine * ray.norm()) {
      num_far_below += enu_per_world * up < -kFarM;
      num_far_above += enu_per_world * up > kFarM;
      num_roof += up > 0.0 && enu_per_world * up < kFarM;
    }
  }
  const auto has = [&](int64_t count) {
    const double share = static_cast<double>(count) / problem_.rays_in_world.size();
    return std::clamp((share - kFewFar) / (kManyFar - kFewFar), 0.0, 1.0);
  };
  const double is_high = has(num_far_below);
  const double has_roof = has(num_roof) * (1.0 - has(num_far_above));
  const bool is_close = enu_per_world * far_ray_in_world_ < kLargestFloorM;
  return is_high * (std::log(kHighSessionShare) + has_roof * std::log(kLowRoofShare)) +
         (is_close ? std::log(kCloseWallShare) : 0.0);
}

double UpEvidence::ScoreFlight(double enu_per_world) const {
  if (problem_.rays_in_world.empty()) {
    return std::log(kUnseenFlightShare);
  }
  const bool films_floor = enu_per_world * far_ray_in_world_ < kLargestFloorM;
  const bool flies = enu_per_world * near_ray_in_world_ > kLeastFlightM;
  return films_floor || flies ? 0.0 : std::log(kLowFlightShare);
}

UpScore UpEvidence::Score(const Eigen::Vector3d& up_in_world) const {
  std::vector<Densities> densities;
  const double shared_pitch = SharedPitch(up_in_world);
  for (const UpView& view : problem_.views) {
    densities.push_back(DensitiesOf(view, up_in_world, shared_pitch));
  }
  UpScore score;
  score.cameras = ScoreHolds(densities, &score.shares);
  if (has_stated_) {
    ScoreStatements(std::move(densities), &score);
  }
  double enu_per_world = 0.0;
  score.positions = ScorePositions(up_in_world, &enu_per_world);
  // Cameras that look straight down hang high, and share no pitch.
  const double share_ahead = 1.0 - score.shares[static_cast<size_t>(PictureUp::kBack)];
  const auto like = [&](double sigma) {
    const double sigmas = shared_pitch / sigma;
    return std::exp(-0.5 * sigmas * sigmas);
  };
  const double steep_share = shared_pitch < 0.0 ? kSteepDownShare : kSteepUpShare;
  score.cameras += share_ahead * std::log((1.0 - steep_share) * like(kSharedPitchSigma) +
                                          steep_share * like(kSteepPitchSigma));
  score.ground = share_ahead * ScoreGround(up_in_world, enu_per_world) +
                 (1.0 - share_ahead) * ScoreFlight(enu_per_world);
  return score;
}

PictureUp UpEvidence::HoldOf(const UpView& view, const Eigen::Vector3d& up_in_world,
                             const UpScore& score) const {
  const Densities densities = DensitiesOf(view, up_in_world, SharedPitch(up_in_world));
  PictureUp best = PictureUp::kTop;
  double best_weight = -1.0;
  for (const PictureUp up : kPictureUps) {
    const size_t hold = static_cast<size_t>(up);
    const double said = score.heeds_statements ? StatementLikelihood(view, hold) : 1.0;
    const double weight = score.shares[hold] * said * densities[hold];
    if (weight > best_weight) {
      best = up;
      best_weight = weight;
    }
  }
  return best;
}

}  // namespace cairn
