#include "ingest/codebook/train_codebook.h"

#include <faiss/impl/FaissException.h>
#include <faiss/impl/ProductQuantizer.h>
#include <fmt/format.h>
#include <omp.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "core/require.h"
#include "ingest/codebook/codebook_option_visit.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kNumQuantiles = 19;  // 0.05, 0.10, ... 0.95.
constexpr int kNumOtherLandmarks = 10'000;
// Number of descriptors measured for the statistics. It gives a quantile near the tail to within
// half a percent.
constexpr int kNumProbes = 2000;
constexpr int kKMeansIterations = 15;
constexpr double kMinVariance = 1e-12;

// FAISS trains small problems several times more slowly with OpenMP threads than without.
class SingleOmpThread {
 public:
  SingleOmpThread() : num_threads_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~SingleOmpThread() { omp_set_num_threads(num_threads_); }
  SingleOmpThread(const SingleOmpThread&) = delete;
  SingleOmpThread& operator=(const SingleOmpThread&) = delete;

 private:
  int num_threads_;
};

// Draws `count` of the numbers below `total`, ascending, each subset equally likely (Knuth's
// algorithm S). Returns all numbers if there are fewer.
std::vector<int64_t> SampleIndices(int64_t total, int64_t count, std::mt19937_64* rng) {
  std::vector<int64_t> sample;
  sample.reserve(std::min(total, count));
  for (int64_t i = 0; i < total && static_cast<int64_t>(sample.size()) < count; ++i) {
    const double needed = static_cast<double>(count - static_cast<int64_t>(sample.size()));
    if (UniformUnit(rng) * static_cast<double>(total - i) < needed) {
      sample.push_back(i);
    }
  }
  return sample;
}

// The raw descriptor of an observation of a landmark.
Eigen::RowVectorXf DescriptorOf(const Reconstruction& reconstruction,
                                const ReconObservation& observation) {
  return reconstruction.images[observation.image_idx].features.descriptors.Row(
      observation.keypoint_idx);
}

DescriptorMatrix DescriptorsOf(const Reconstruction& reconstruction,
                               const std::vector<ReconObservation>& observations) {
  DescriptorMatrix descriptors(observations.size(), reconstruction.descriptor_dim());
  for (size_t i = 0; i < observations.size(); ++i) {
    descriptors.row(i) = DescriptorOf(reconstruction, observations[i]);
  }
  return descriptors;
}

// A random subset of the descriptors that belong to landmarks.
DescriptorMatrix SampleTrainingSet(const Reconstruction& reconstruction, int max_count,
                                   std::mt19937_64* rng) {
  int64_t total = 0;
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    total += static_cast<int64_t>(landmark.observations.size());
  }
  std::vector<ReconObservation> chosen;
  const std::vector<int64_t> sample = SampleIndices(total, max_count, rng);
  auto next = sample.begin();
  int64_t begin = 0;
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    const auto end = begin + static_cast<int64_t>(landmark.observations.size());
    for (; next != sample.end() && *next < end; ++next) {
      chosen.push_back(landmark.observations[*next - begin]);
    }
    begin = end;
  }
  return DescriptorsOf(reconstruction, chosen);
}

// Distributes the principal components, given in order of falling variance, among subspaces so that
// the products of the variances are about equal (eigenvalue allocation, Ge et al. 2014). Returns
// the component of each projected dimension.
std::vector<int> BalanceSubspaces(const Eigen::VectorXd& variances, int num_subspaces) {
  const int subspace_dim = static_cast<int>(variances.size()) / num_subspaces;
  const double smallest = std::max(variances.minCoeff(), kMinVariance);
  std::vector<std::vector<int>> components(num_subspaces);
  std::vector<double> log_products(num_subspaces, 0.0);
  for (int component = 0; component < variances.size(); ++component) {
    int best = -1;
    for (int s = 0; s < num_subspaces; ++s) {
      const bool full = static_cast<int>(components[s].size()) == subspace_dim;
      if (!full && (best < 0 || log_products[s] < log_products[best])) {
        best = s;
      }
    }
    components[best].push_back(component);
    // Divides by the smallest variance, so that no factor is below one and products only grow.
    log_products[best] += std::log(std::max(variances[component], kMinVariance) / smallest);
  }
  std::vector<int> order;
  for (const std::vector<int>& subspace : components) {
    order.insert(order.end(), subspace.begin(), subspace.end());
  }
  return order;
}

// Covariance of centered rows, summed in blocks of doubles.
Eigen::MatrixXd CovarianceOf(const DescriptorMatrix& rows, const Eigen::VectorXd& mean) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(mean.size(), mean.size());
  constexpr Eigen::Index kBlock = 4096;
  for (Eigen::Index begin = 0; begin < rows.rows(); begin += kBlock) {
    const Eigen::Index count = std::min(kBlock, rows.rows() - begin);
    const Eigen::MatrixXd centered =
        rows.middleRows(begin, count).cast<double>().rowwise() - mean.transpose();
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(centered.transpose());
  }
  covariance.triangularView<Eigen::StrictlyUpper>() = covariance.transpose();
  return covariance / static_cast<double>(rows.rows());
}

// The rows of a projection, best first, and the variance of the training set along each of them.
struct ProjectionRows {
  Eigen::MatrixXd rows;
  Eigen::VectorXd variances;
};

// The directions of largest variance.
ProjectionRows PrincipalComponents(const Eigen::MatrixXd& covariance, int count) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  return {solver.eigenvectors().rowwise().reverse().leftCols(count).transpose(),
          solver.eigenvalues().reverse().head(count)};
}

// Mean covariance of the descriptors of one landmark, over landmarks with `max_count` descriptors
// together, with a little of the identity so that it can be inverted.
Eigen::MatrixXd WithinLandmarkCovariance(const Reconstruction& reconstruction,
                                         DescriptorNormalization normalization, int max_count) {
  constexpr double kShrinkage = 1e-2;
  const int dim = reconstruction.descriptor_dim();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(dim, dim);
  double num_differences = 0.0;
  int num_left = max_count;
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    const auto num_observations = static_cast<int>(landmark.observations.size());
    if (num_observations < 2 || num_observations > num_left) {
      continue;
    }
    num_left -= num_observations;
    DescriptorMatrix descriptors = DescriptorsOf(reconstruction, landmark.observations);
    NormalizeDescriptors(normalization, &descriptors);
    const Eigen::MatrixXd centered =
        (descriptors.rowwise() - descriptors.colwise().mean()).cast<double>();
    sum.noalias() += centered.transpose() * centered;
    num_differences += num_observations - 1;
  }
  if (num_differences == 0.0) {
    throw Error(ErrorCode::kBadInput,
                "a likelihood-ratio projection needs landmarks with two descriptors or more");
  }
  const Eigen::MatrixXd within = sum / num_differences;
  return within + kShrinkage * within.trace() / dim * Eigen::MatrixXd::Identity(dim, dim);
}

// The directions along which landmarks differ most, relative to the descriptors of one landmark.
// The squared distance in the projected space is the statistic of the likelihood-ratio test that
// two descriptors belong to one landmark (Bosse and Zlot 2009): with W the covariance within
// landmarks and T that of all descriptors, the generalized eigenvectors T v = l W v, scaled by
// sqrt(1 - 1/l).
ProjectionRows LikelihoodRatioComponents(const Eigen::MatrixXd& covariance,
                                         const Eigen::MatrixXd& within, int count) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance, within);
  ProjectionRows projection;
  projection.rows = solver.eigenvectors().rowwise().reverse().leftCols(count).transpose();
  const Eigen::VectorXd ratios = solver.eigenvalues().reverse().head(count).cwiseMax(1.0 + 1e-6);
  projection.rows =
      (1.0 - ratios.cwiseInverse().array()).sqrt().matrix().asDiagonal() * projection.rows;
  projection.variances = (projection.rows * covariance * projection.rows.transpose()).diagonal();
  return projection;
}

// Sets mean and projection, its rows distributed among subspaces. `normalized` is the training set.
void TrainProjection(const DescriptorMatrix& normalized, const Reconstruction& reconstruction,
                     const CodebookOptions& options, Codebook* codebook) {
  const Eigen::VectorXd mean = normalized.cast<double>().colwise().mean();
  const Eigen::MatrixXd covariance = CovarianceOf(normalized, mean);
  const ProjectionRows best =
      options.projection == ProjectionKind::kPrincipalComponents
          ? PrincipalComponents(covariance, options.projected_dim)
          : LikelihoodRatioComponents(
                covariance,
                WithinLandmarkCovariance(reconstruction, codebook->normalization,
                                         options.max_training_descriptors),
                options.projected_dim);
  const std::vector<int> order = BalanceSubspaces(best.variances, options.num_subspaces);
  codebook->mean = mean.cast<float>();
  codebook->projection.resize(options.projected_dim, mean.size());
  for (int i = 0; i < options.projected_dim; ++i) {
    Eigen::VectorXd row = best.rows.row(order[i]).transpose();
    Eigen::Index largest;
    row.cwiseAbs().maxCoeff(&largest);
    if (row[largest] < 0.0) {
      row = -row;  // The sign of an eigenvector is arbitrary.
    }
    codebook->projection.row(i) = row.transpose().cast<float>();
  }
}

void TrainWords(const DescriptorMatrix& projected, const CodebookOptions& options,
                Codebook* codebook) {
  codebook->num_subspaces = options.num_subspaces;
  try {
    const SingleOmpThread single_thread;
    faiss::ProductQuantizer quantizer(options.projected_dim, options.num_subspaces, 8);
    quantizer.cp.niter = kKMeansIterations;
    quantizer.cp.seed = static_cast<int>(options.seed & 0x7fffffff);
    quantizer.cp.min_points_per_centroid = 1;  // Avoids FAISS's warning about small training sets.
    quantizer.cp.max_points_per_centroid =
        options.max_training_descriptors;  // The training set is already sampled.
    quantizer.train(static_cast<size_t>(projected.rows()), projected.data());
    codebook->words = std::move(quantizer.centroids);
  } catch (const faiss::FaissException& e) {
    throw Error(ErrorCode::kInternal, fmt::format("FAISS cannot train a quantizer: {}", e.what()));
  }
}

std::vector<float> Quantiles(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  std::vector<float> quantiles(kNumQuantiles, 0.0f);
  for (int i = 0; i < kNumQuantiles && !values.empty(); ++i) {
    const double rank = (i + 1) / (kNumQuantiles + 1.0) * static_cast<double>(values.size() - 1);
    quantiles[i] = values[static_cast<size_t>(std::lround(rank))];
  }
  return quantiles;
}

// Distance from `query` to the nearest row other than `excluded`; infinite if there is none.
float NearestDistance(const Eigen::RowVectorXf& query, const DescriptorMatrix& rows,
                      Eigen::Index excluded) {
  float best = std::numeric_limits<float>::infinity();
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    if (i != excluded) {
      best = std::min(best, (rows.row(i) - query).squaredNorm());
    }
  }
  return std::sqrt(best);
}

DescriptorMatrix Requantized(const DescriptorCodec& codec, const DescriptorMatrix& projected) {
  return codec.Decode(codec.Encode(projected).data(), static_cast<int>(projected.rows()));
}

// One quantized descriptor from each of up to kNumOtherLandmarks landmarks. `landmark_idx` has the
// landmark of each row.
DescriptorMatrix SampleOthers(const Reconstruction& reconstruction, const DescriptorCodec& codec,
                              std::mt19937_64* rng, std::vector<int64_t>* landmark_idx) {
  *landmark_idx =
      SampleIndices(static_cast<int64_t>(reconstruction.landmarks.size()), kNumOtherLandmarks, rng);
  std::erase_if(*landmark_idx,
                [&](int64_t i) { return reconstruction.landmarks[i].observations.empty(); });
  std::vector<ReconObservation> observations;
  for (const int64_t i : *landmark_idx) {
    const std::vector<ReconObservation>& all = reconstruction.landmarks[i].observations;
    observations.push_back(all[UniformIndex(all.size(), rng)]);
  }
  return Requantized(codec, codec.Project(DescriptorsOf(reconstruction, observations)));
}

void MeasureDistances(const Reconstruction& reconstruction, std::mt19937_64* rng,
                      Codebook* codebook) {
  // The codec does not need the statistics, which are not computed yet.
  const DescriptorCodec codec(std::make_shared<const Codebook>(*codebook));
  std::vector<int64_t> other_idx;
  const DescriptorMatrix others = SampleOthers(reconstruction, codec, rng, &other_idx);

  std::vector<float> same_distances, other_distances;
  const std::vector<int64_t> probes =
      SampleIndices(static_cast<int64_t>(reconstruction.landmarks.size()), kNumProbes, rng);
  for (const int64_t landmark_idx : probes) {
    const ReconLandmark& landmark = reconstruction.landmarks[landmark_idx];
    if (landmark.observations.size() < 2) {
      continue;
    }
    const DescriptorMatrix projected =
        codec.Project(DescriptorsOf(reconstruction, landmark.observations));
    const auto probe = static_cast<Eigen::Index>(UniformIndex(projected.rows(), rng));
    same_distances.push_back(
        NearestDistance(projected.row(probe), Requantized(codec, projected), probe));
    const auto self = std::lower_bound(other_idx.begin(), other_idx.end(), landmark_idx);
    const bool is_other = self != other_idx.end() && *self == landmark_idx;
    const float distance =
        NearestDistance(projected.row(probe), others, is_other ? self - other_idx.begin() : -1);
    if (std::isfinite(distance)) {
      other_distances.push_back(distance);
    }
  }
  codebook->same_landmark_distance_quantiles = Quantiles(std::move(same_distances));
  codebook->other_landmark_distance_quantiles = Quantiles(std::move(other_distances));
}

}  // namespace

void CodebookOptions::Validate() const {
  CheckOptions("ingest.codebook", *this);
  RequireOption(projected_dim % num_subspaces == 0,
                "ingest.codebook.num_subspaces must divide projected_dim");
}

Codebook TrainCodebook(const Reconstruction& reconstruction, const CodebookOptions& options) {
  options.Validate();
  if (reconstruction.descriptor_dim() < options.projected_dim) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the reconstruction's descriptors have {} dimensions; they cannot be "
                            "projected to {}",
                            reconstruction.descriptor_dim(), options.projected_dim));
  }
  std::mt19937_64 rng(options.seed);
  DescriptorMatrix training =
      SampleTrainingSet(reconstruction, options.max_training_descriptors, &rng);
  if (training.rows() < Codebook::kNumWords) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("only {} descriptors belong to landmarks; a codebook needs {}",
                            training.rows(), Codebook::kNumWords));
  }
  Codebook codebook;
  codebook.descriptor_type = reconstruction.descriptor_type;
  NormalizeDescriptors(codebook.normalization, &training);
  TrainProjection(training, reconstruction, options, &codebook);
  const DescriptorMatrix projected =
      (training.rowwise() - codebook.mean.transpose()) * codebook.projection.transpose();
  TrainWords(projected, options, &codebook);
  MeasureDistances(reconstruction, &rng, &codebook);
  codebook.Validate();
  return codebook;
}

}  // namespace cairn
