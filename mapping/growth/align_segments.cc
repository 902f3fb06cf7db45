#include "mapping/growth/align_segments.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/scene/triangulate.h"
#include "engine/pose/p3p.h"
#include "engine/pose/ransac.h"

namespace cairn {
namespace {

// As in the adjustment, but a pixel counts as twice as uncertain.
constexpr double kMaxMeetingSigmas = 4.0;
constexpr double kPixelSlack = 2.0;
// Scale of Cauchy's loss while the similarity is refined.
constexpr double kMeetingLossSigmas = 2.0;

// A landmark in the world of its segment.
struct Known {
  Eigen::Vector3d x_in_own = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// A point that both segments know.
struct SharedPoint {
  std::array<Known, 2> known;  // In a and in b.
  int first_observation = 0, end_observation = 0;
};

// A photo of one segment sees a shared point.
struct SegmentObservation {
  int side = 0;  // 0: the photo is in a.
  int image = 0;
  int point = 0;
  const Camera* camera = nullptr;
  Rigid3d cam_from_own;
  Eigen::Vector2d pixel;
  double sigma_px = 1.0;
};

// The landmarks of a segment by track, ascending.
std::vector<std::pair<int, int>> LandmarkOfTrack(const TrackTable& tracks, const Segment& segment) {
  std::vector<std::pair<int, int>> landmarks;
  for (size_t i = 0; i < segment.model.landmarks.size(); ++i) {
    const ReconObservation& first = segment.model.landmarks[i].observations.front();
    const int photo = segment.photo_of_image[first.image_idx];
    landmarks.emplace_back(tracks.track_of_keypoint[photo][first.keypoint_idx],
                           static_cast<int>(i));
  }
  std::sort(landmarks.begin(), landmarks.end());
  return landmarks;
}

struct SharedScene {
  std::vector<SharedPoint> points;
  std::vector<SegmentObservation> observations;           // By point.
  std::array<std::vector<std::vector<int>>, 2> of_image;  // Observations: [side][image].
};

// Adds what one segment knows of the last point. False if that is nothing certain.
bool AddKnown(const Segment& segment, int side, int landmark_idx, SharedScene* scene) {
  const ReconLandmark& landmark = segment.model.landmarks[landmark_idx];
  const std::vector<PointObservation> observations = PointObservationsOf(segment.model, landmark);
  const auto uncertainty = EstimateUncertainty(observations, landmark.x_in_world);
  if (!uncertainty) {
    return false;
  }
  scene->points.back().known[side] = {landmark.x_in_world, uncertainty->covariance};
  for (size_t i = 0; i < observations.size(); ++i) {
    const PointObservation& seen = observations[i];
    scene->observations.push_back({side, landmark.observations[i].image_idx,
                                   static_cast<int>(scene->points.size()) - 1, seen.camera,
                                   seen.cam_from_world, seen.pixel, seen.sigma_px});
  }
  return true;
}

SharedScene FindShared(const TrackTable& tracks, const Segment& a, const Segment& b) {
  const auto of_a = LandmarkOfTrack(tracks, a), of_b = LandmarkOfTrack(tracks, b);
  SharedScene scene;
  for (auto p = of_a.begin(), q = of_b.begin(); p != of_a.end() && q != of_b.end();) {
    if (p->first != q->first) {
      ++(p->first < q->first ? p : q);
      continue;
    }
    const int first = static_cast<int>(scene.observations.size());
    scene.points.push_back({.known = {}, .first_observation = first});
    if (AddKnown(a, 0, p->second, &scene) && AddKnown(b, 1, q->second, &scene)) {
      scene.points.back().end_observation = static_cast<int>(scene.observations.size());
    } else {
      scene.points.pop_back();
      scene.observations.resize(first);
    }
    ++p, ++q;
  }
  scene.of_image = {std::vector<std::vector<int>>(a.model.images.size()),
                    std::vector<std::vector<int>>(b.model.images.size())};
  for (int i = 0; i < static_cast<int>(scene.observations.size()); ++i) {
    scene.of_image[scene.observations[i].side][scene.observations[i].image].push_back(i);
  }
  return scene;
}

// The similarity in both directions.
struct Meeting {
  std::array<Sim3d, 2> own_from_other;  // a_from_b and b_from_a.
};

Meeting MeetingOf(const Sim3d& b_from_a) { return {{b_from_a.Inverse(), b_from_a}}; }

// The error of an observation in standard deviations, whitened, with its derivative by a small
// similarity after b_from_a: translation, rotation, logarithm of the scale.
struct WhiteError {
  Eigen::Vector2d error;
  Eigen::Matrix<double, 2, 7> jacobian;
};

// See LoRansac for the contract of the methods.
class MeetingProblem {
 public:
  using Model = Meeting;
  static constexpr int kMaxModels = 4;

  explicit MeetingProblem(const SharedScene& scene) : scene_(scene) {}

  int SampleModels(Random* random, std::array<Model, kMaxModels>* models) const {
    const SegmentObservation& first =
        scene_.observations[random->Index(static_cast<int>(scene_.observations.size()))];
    const std::vector<int>& of_image = scene_.of_image[first.side][first.image];
    const int count = static_cast<int>(of_image.size());
    if (count < 3) {
      return 0;
    }
    std::array<int, 3> sample;
    for (int i = 0; i < 3; ++i) {
      do {
        sample[i] = of_image[random->Index(count)];
      } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
    }
    return Solve(sample, models);
  }

  double ScoreMinimal(const Model& model, double score_to_beat) const {
    double score = 0.0;
    const int count = static_cast<int>(scene_.points.size());
    for (int i = 0; i < count && score + (count - i) > score_to_beat; ++i) {
      score += GainOf(model, i);
    }
    return score;
  }

  std::optional<std::pair<Model, double>> Optimize(const Model& model) const {
    constexpr int kIterations = 6;
    std::pair<Model, double> best(model, ScoreMinimal(model, -1.0));
    Model current = model;
    for (int i = 0; i < kIterations; ++i) {
      current = Step(current);
      const double score = ScoreMinimal(current, -1.0);
      if (!(score > best.second)) {
        break;
      }
      best = {current, score};
    }
    return best;
  }

  double InlierSampleProbability(const Model& model) const {
    return SampleProbabilityOfScore(static_cast<double>(AgreeingPoints(model).size()));
  }
  double SampleProbabilityOfScore(double score) const {
    return std::pow(score / static_cast<double>(scene_.points.size()), 3);
  }

  // Points of which more than half of the observations agree.
  std::vector<int> AgreeingPoints(const Model& model) const {
    std::vector<int> agreeing;
    for (int i = 0; i < static_cast<int>(scene_.points.size()); ++i) {
      const SharedPoint& point = scene_.points[i];
      int num_agreeing = 0;
      for (int k = point.first_observation; k < point.end_observation; ++k) {
        num_agreeing += Gain(model, scene_.observations[k]) > 0.0 ? 1 : 0;
      }
      if (2 * num_agreeing > point.end_observation - point.first_observation) {
        agreeing.push_back(i);
      }
    }
    return agreeing;
  }

 private:
  // The models of three observations of one image.
  int Solve(const std::array<int, 3>& sample, std::array<Model, kMaxModels>* models) const {
    const int side = scene_.observations[sample[0]].side;
    const Rigid3d& cam_from_own = scene_.observations[sample[0]].cam_from_own;
    std::array<Eigen::Vector3d, 3> bearings, x_in_other;
    std::array<double, 3> depths;
    for (int i = 0; i < 3; ++i) {
      const SegmentObservation& seen = scene_.observations[sample[i]];
      const SharedPoint& point = scene_.points[seen.point];
      const auto ray = seen.camera->Unproject(seen.pixel);
      if (!ray) {
        return 0;
      }
      bearings[i] = *ray;
      x_in_other[i] = point.known[1 - side].x_in_own;
      depths[i] = (cam_from_own * point.known[side].x_in_own).norm();
    }
    std::array<Eigen::Matrix<double, 3, 4>, 4> poses;
    const int num_poses = SolveP3p(bearings, x_in_other, &poses);
    for (int i = 0; i < num_poses; ++i) {
      const Rigid3d cam_from_other(Eigen::Matrix3d(poses[i].leftCols<3>()),
                                   Eigen::Vector3d(poses[i].col(3)));
      std::array<double, 3> scales;
      for (int k = 0; k < 3; ++k) {
        scales[k] = depths[k] / (cam_from_other * x_in_other[k]).norm();
      }
      std::sort(scales.begin(), scales.end());
      const Sim3d cam_from_other_scaled{scales[1], cam_from_other.rotation,
                                        scales[1] * cam_from_other.translation};
      const Sim3d own_from_other = cam_from_own.Inverse() * cam_from_other_scaled;
      (*models)[i] = MeetingOf(side == 1 ? own_from_other : own_from_other.Inverse());
    }
    return num_poses;
  }

  // Nothing if the point is not in the picture.
  std::optional<WhiteError> ErrorOf(const Model& model, const SegmentObservation& seen) const {
    const Sim3d& own_from_other = model.own_from_other[seen.side];
    const Known& other = scene_.points[seen.point].known[1 - seen.side];
    const Eigen::Vector3d x_in_own = own_from_other * other.x_in_own;
    Eigen::Matrix<double, 2, 3> projection;
    const auto pixel = seen.camera->ProjectWithJacobian(seen.cam_from_own * x_in_own, &projection);
    if (!pixel) {
      return std::nullopt;
    }
    const Eigen::Matrix3d turn = own_from_other.scale * own_from_other.rotation.toRotationMatrix();
    const Eigen::Matrix<double, 2, 3> by_own =
        projection * seen.cam_from_own.rotation.toRotationMatrix();
    const Eigen::Matrix<double, 2, 3> by_other = by_own * turn;
    Eigen::Matrix2d covariance = by_other * other.covariance * by_other.transpose();
    covariance.diagonal().array() += std::pow(kPixelSlack * seen.sigma_px, 2);
    const Eigen::LLT<Eigen::Matrix2d> root(covariance);
    // A small similarity moves the point as b knows it.
    const Eigen::Vector3d x_in_b = seen.side == 1 ? x_in_own : other.x_in_own;
    Eigen::Matrix<double, 3, 7> moved;
    moved << Eigen::Matrix3d::Identity(), -Skew(x_in_b), x_in_b;
    WhiteError white;
    white.error = root.matrixL().solve(*pixel - seen.pixel);
    const Eigen::Matrix<double, 2, 3> by_b =
        seen.side == 1 ? by_own : Eigen::Matrix<double, 2, 3>(-by_other);
    white.jacobian = root.matrixL().solve(by_b * moved);
    return white;
  }

  double Gain(const Model& model, const SegmentObservation& seen) const {
    const auto white = ErrorOf(model, seen);
    return white ? std::max(0.0, 1.0 - white->error.squaredNorm() /
                                           (kMaxMeetingSigmas * kMaxMeetingSigmas))
                 : 0.0;
  }

  // The mean over the observations of a point.
  double GainOf(const Model& model, int point_idx) const {
    const SharedPoint& point = scene_.points[point_idx];
    double sum = 0.0;
    for (int i = point.first_observation; i < point.end_observation; ++i) {
      sum += Gain(model, scene_.observations[i]);
    }
    return sum / (point.end_observation - point.first_observation);
  }

  // A step of Gauss-Newton on Cauchy's loss over the observations that agree.
  Model Step(const Model& model) const {
    using Vector7d = Eigen::Matrix<double, 7, 1>;
    Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
    Vector7d gradient = Vector7d::Zero();
    for (const SegmentObservation& seen : scene_.observations) {
      const auto white = ErrorOf(model, seen);
      const double sq_error = white ? white->error.squaredNorm() : 0.0;
      if (!white || sq_error > kMaxMeetingSigmas * kMaxMeetingSigmas) {
        continue;
      }
      const double weight = 1.0 / (1.0 + sq_error / (kMeetingLossSigmas * kMeetingLossSigmas));
      normal += weight * white->jacobian.transpose() * white->jacobian;
      gradient += weight * white->jacobian.transpose() * white->error;
    }
    const Vector7d change = -normal.ldlt().solve(gradient);
    if (!change.allFinite()) {
      return model;
    }
    const Sim3d step{std::exp(change[6]), ExpSo3(change.segment<3>(3)), change.head<3>()};
    return MeetingOf(step * model.own_from_other[1]);
  }

  const SharedScene& scene_;
};

}  // namespace

std::optional<SegmentAlignment> AlignSegments(const TrackTable& tracks, const Segment& a,
                                              const Segment& b, int min_points, uint64_t seed) {
  const SharedScene scene = FindShared(tracks, a, b);
  if (static_cast<int>(scene.points.size()) < min_points) {
    return std::nullopt;
  }
  MeetingProblem problem(scene);
  const auto found = LoRansac(&problem, RansacOptions(), seed);
  if (!found.model) {
    return std::nullopt;
  }
  const int num_agreeing = static_cast<int>(problem.AgreeingPoints(*found.model).size());
  if (num_agreeing < min_points) {
    return std::nullopt;
  }
  return SegmentAlignment{found.model->own_from_other[1], num_agreeing,
                          static_cast<int>(scene.points.size())};
}

}  // namespace cairn
