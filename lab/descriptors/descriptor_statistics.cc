#include "lab/descriptors/descriptor_statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "core/check.h"
#include "core/statistics.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kNumProbes = 500;
constexpr std::array kAngleEdgesRad = {0.0f,  0.01f, 0.02f, 0.035f, 0.05f, 0.075f, 0.1f,
                                       0.15f, 0.2f,  0.3f,  0.45f,  0.6f,  0.8f,   1.4f};
constexpr std::array kScaleEdges = {0.0f, 0.1f, 0.2f, 0.3f, 0.45f, 0.6f, 0.8f, 1.0f, 1.5f, 2.5f};
constexpr float kNearAngleRad = 0.06f;
constexpr float kNearbyLog2Scale = 0.3f;
// Pairs to try after each pair, until one shares no look with it.
constexpr size_t kPairsTried = 5;

// Returns the principal axes as columns, the strongest first.
Eigen::MatrixXf PrincipalAxes(const DescriptorMatrix& root, Eigen::VectorXf* variances) {
  const DescriptorMatrix centered = root.rowwise() - root.colwise().mean();
  const Eigen::MatrixXf covariance =
      centered.transpose() * centered / static_cast<float>(root.rows() - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(covariance);
  *variances = solver.eigenvalues().reverse().cwiseMax(0.0f);
  return solver.eigenvectors().rowwise().reverse();
}

std::vector<int> Shuffled(Eigen::Index count, uint64_t seed) {
  std::vector<int> order(static_cast<size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::mt19937_64 generator(seed);
  for (size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[generator() % i]);
  }
  return order;
}

bool ShareALook(const LookPair& p, const LookPair& q) {
  return p.a == q.a || p.a == q.b || p.b == q.a || p.b == q.b;
}

}  // namespace

std::vector<LookPair> PairsOf(const std::vector<RealLook>& looks) {
  std::vector<LookPair> pairs;
  for (size_t a = 0; a < looks.size(); ++a) {
    for (size_t b = a + 1; b < looks.size() && looks[b].ornament == looks[a].ornament; ++b) {
      pairs.push_back({.a = static_cast<int>(a),
                       .b = static_cast<int>(b),
                       .angle_rad = std::hypot(looks[a].azimuth_rad - looks[b].azimuth_rad,
                                               looks[a].elevation_rad - looks[b].elevation_rad),
                       .log2_scale = std::abs(looks[a].log2_scale - looks[b].log2_scale)});
    }
  }
  return pairs;
}

std::vector<float> SqDistances(const DescriptorMatrix& root, const std::vector<LookPair>& pairs) {
  std::vector<float> sq_distances;
  sq_distances.reserve(pairs.size());
  for (const LookPair& pair : pairs) {
    sq_distances.push_back((root.row(pair.a) - root.row(pair.b)).squaredNorm());
  }
  return sq_distances;
}

DescriptorMatrix FirstLooks(const RealLooks& looks) {
  std::vector<int> first;
  for (int i = 0; i < looks.size(); ++i) {
    if (i == 0 || looks.looks[i].ornament != looks.looks[i - 1].ornament) {
      first.push_back(i);
    }
  }
  return looks.root(first, Eigen::all);
}

RealLooks Simulate(const RealLooks& like, const DescriptorModel& model) {
  RealLooks result{.looks = like.looks, .root = DescriptorMatrix(like.size(), model.kDim)};
  for (int i = 0; i < like.size(); ++i) {
    const RealLook& look = like.looks[i];
    result.root.row(i) =
        model.Describe({.ornament = static_cast<uint64_t>(look.ornament),
                        .landmark = static_cast<uint64_t>(look.landmark),
                        .appearance_mode = static_cast<uint32_t>(look.appearance_mode),
                        .view_azimuth_rad = look.azimuth_rad,
                        .view_elevation_rad = look.elevation_rad,
                        .log2_scale = look.log2_scale,
                        .observation = static_cast<uint64_t>(look.image)});
  }
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &result.root);
  return result;
}

DescriptorMatrix SimulateClutter(int count, const DescriptorModel& model) {
  DescriptorMatrix root(count, model.kDim);
  for (int i = 0; i < count; ++i) {
    root.row(i) = model.DescribeClutter(static_cast<uint64_t>(i));
  }
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &root);
  return root;
}

Eigen::VectorXf PrincipalSigmas(const DescriptorMatrix& root) {
  Eigen::VectorXf variances;
  PrincipalAxes(root, &variances);
  return variances.cwiseSqrt();
}

Eigen::VectorXf WithinSigmas(const DescriptorMatrix& root, const std::vector<LookPair>& pairs,
                             float max_distance) {
  Eigen::VectorXf variances;
  const Eigen::MatrixXf axes = PrincipalAxes(root, &variances);
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(axes.cols());
  int count = 0;
  for (const LookPair& pair : pairs) {
    const Eigen::RowVectorXf difference = root.row(pair.a) - root.row(pair.b);
    if (difference.norm() <= max_distance) {
      sum += (difference * axes).transpose().cwiseAbs2();
      ++count;
    }
  }
  return (sum / (2.0f * static_cast<float>(std::max(1, count)))).cwiseSqrt();
}

std::vector<float> NearestDistances(const DescriptorMatrix& root, int num_others, uint64_t seed) {
  const std::vector<int> probes = Shuffled(root.rows(), seed);
  const std::vector<int> others = Shuffled(root.rows(), seed + 1);
  const auto num_probes = std::min<size_t>(kNumProbes, probes.size());
  const auto num_rows = std::min<size_t>(static_cast<size_t>(num_others), others.size());
  const std::vector<int> rows(others.begin(), others.begin() + static_cast<int>(num_rows));
  const DescriptorMatrix candidates = root(rows, Eigen::all);
  std::vector<float> distances;
  for (size_t i = 0; i < num_probes; ++i) {
    Eigen::VectorXf sq = 2.0f - 2.0f * (candidates * root.row(probes[i]).transpose()).array();
    const auto self = std::find(rows.begin(), rows.end(), probes[i]);
    if (self != rows.end()) {
      sq[self - rows.begin()] = 4.0f;
    }
    distances.push_back(std::sqrt(std::max(0.0f, sq.minCoeff())));
  }
  return distances;
}

std::vector<float> RandomDistances(const DescriptorMatrix& root, uint64_t seed) {
  constexpr int kCount = 50'000;
  std::mt19937_64 generator(seed);
  const auto count = static_cast<uint64_t>(root.rows());
  std::vector<float> distances;
  while (count > 1 && distances.size() < kCount) {
    const auto a = static_cast<Eigen::Index>(generator() % count);
    const auto b = static_cast<Eigen::Index>(generator() % count);
    if (a != b) {
      distances.push_back((root.row(a) - root.row(b)).norm());
    }
  }
  return distances;
}

std::vector<ViewCell> ViewCells(const std::vector<LookPair>& pairs, int min_pairs) {
  std::vector<ViewCell> cells;
  for (size_t angle = 1; angle < kAngleEdgesRad.size(); ++angle) {
    for (size_t scale = 1; scale < kScaleEdges.size(); ++scale) {
      ViewCell cell{.min_angle_rad = kAngleEdgesRad[angle - 1],
                    .max_angle_rad = kAngleEdgesRad[angle],
                    .min_log2_scale = kScaleEdges[scale - 1],
                    .max_log2_scale = kScaleEdges[scale],
                    .pairs = {}};
      for (size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].angle_rad >= cell.min_angle_rad && pairs[i].angle_rad < cell.max_angle_rad &&
            pairs[i].log2_scale >= cell.min_log2_scale &&
            pairs[i].log2_scale < cell.max_log2_scale) {
          cell.pairs.push_back(static_cast<int>(i));
        }
      }
      if (static_cast<int>(cell.pairs.size()) >= min_pairs) {
        cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

NearSpread SpreadOfNearViews(const std::vector<RealLook>& looks, const std::vector<LookPair>& pairs,
                             const std::vector<float>& sq_distances) {
  std::vector<LookPair> near;
  std::vector<float> logs;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].angle_rad < kNearAngleRad && pairs[i].log2_scale < kNearbyLog2Scale) {
      near.push_back(pairs[i]);
      logs.push_back(std::log(std::max(1e-6f, sq_distances[i])));
    }
  }
  std::vector<double> first, second;
  for (size_t i = 0; i < near.size(); ++i) {
    const int ornament = looks[near[i].a].ornament;
    for (size_t j = i + 1; j < std::min(near.size(), i + 1 + kPairsTried); ++j) {
      if (looks[near[j].a].ornament == ornament && !ShareALook(near[i], near[j])) {
        first.push_back(logs[i]);
        second.push_back(logs[j]);
        break;
      }
    }
  }
  NearSpread spread;
  if (first.size() > 2) {
    const auto count = static_cast<Eigen::Index>(first.size());
    Eigen::ArrayXd x = Eigen::Map<Eigen::ArrayXd>(first.data(), count);
    Eigen::ArrayXd y = Eigen::Map<Eigen::ArrayXd>(second.data(), count);
    x -= x.mean();
    y -= y.mean();
    spread.log_sq_distance_range = ValueAtShare(logs, 0.75) - ValueAtShare(logs, 0.25);
    spread.landmark_correlation =
        static_cast<float>((x * y).sum() / std::sqrt(x.square().sum() * y.square().sum()));
  }
  return spread;
}

}  // namespace cairn
