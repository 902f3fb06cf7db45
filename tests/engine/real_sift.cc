#include "engine/real_sift.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>
#include <random>
#include <stdexcept>
#include <vector>

namespace cairn::testing {
namespace {

constexpr int kDim = 16;
constexpr int kNumSubspaces = 8;

DescriptorMatrix ReadVectors(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  int32_t shape[2] = {};
  file.read(reinterpret_cast<char*>(shape), sizeof(shape));
  std::vector<uint8_t> bytes(static_cast<size_t>(shape[0]) * shape[1]);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) {
    throw std::runtime_error("cannot read " + path.string());
  }
  using Bytes = Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Bytes>(bytes.data(), shape[0], shape[1]).cast<float>();
}

// Principal axes in rows; strong and weak ones in turn, which balances subspaces of two.
DescriptorMatrix BalancedPrincipalAxes(const DescriptorMatrix& centered) {
  const Eigen::MatrixXf covariance = centered.transpose() * centered;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(covariance);
  DescriptorMatrix axes(kDim, centered.cols());
  for (int i = 0; i < kDim; ++i) {
    const int rank = i % 2 == 0 ? i / 2 : kDim - 1 - i / 2;
    axes.row(i) = solver.eigenvectors().col(centered.cols() - 1 - rank).transpose();
  }
  return axes;
}

// Pieces of random vectors.
std::vector<float> RandomWords(const DescriptorMatrix& projected) {
  std::mt19937_64 random(1);
  std::vector<float> words;
  for (int m = 0; m < kNumSubspaces; ++m) {
    for (int w = 0; w < Codebook::kNumWords; ++w) {
      const auto row = static_cast<Eigen::Index>(random() % projected.rows());
      words.push_back(projected(row, 2 * m));
      words.push_back(projected(row, 2 * m + 1));
    }
  }
  return words;
}

std::vector<float> NearestDistanceQuantiles(const DescriptorMatrix& queries,
                                            const DescriptorMatrix& landmarks) {
  std::vector<float> distances;
  for (Eigen::Index i = 0; i < queries.rows(); ++i) {
    distances.push_back((landmarks.rowwise() - queries.row(i)).rowwise().norm().minCoeff());
  }
  std::sort(distances.begin(), distances.end());
  std::vector<float> quantiles;
  for (size_t i = 1; i <= 19; ++i) {
    quantiles.push_back(distances[distances.size() * i / 20]);
  }
  return quantiles;
}

}  // namespace

SyntheticDescriptors RealSift(const std::filesystem::path& u8bin, int num_queries) {
  auto codebook = std::make_shared<Codebook>();
  codebook->id = CodebookId{1};
  codebook->descriptor_type = "sift";
  DescriptorMatrix vectors = ReadVectors(u8bin);
  NormalizeDescriptors(codebook->normalization, &vectors);
  codebook->mean = vectors.colwise().mean();
  vectors.rowwise() -= codebook->mean.transpose();
  codebook->projection = BalancedPrincipalAxes(vectors);
  codebook->num_subspaces = kNumSubspaces;
  const DescriptorMatrix projected = vectors * codebook->projection.transpose();
  codebook->words = RandomWords(projected);

  SyntheticDescriptors data;
  const DescriptorMatrix landmarks = projected.topRows(projected.rows() - num_queries);
  const DescriptorCodec codec(codebook);
  data.codes = codec.Encode(landmarks);
  data.descriptors_per_landmark = 1;
  data.queries = projected.bottomRows(num_queries);
  data.true_landmarks.assign(num_queries, SyntheticDescriptors::kNoLandmark);
  codebook->same_landmark_distance_quantiles = NearestDistanceQuantiles(
      data.queries, codec.Decode(data.codes.data(), static_cast<int>(landmarks.rows())));
  codebook->other_landmark_distance_quantiles = codebook->same_landmark_distance_quantiles;
  data.codebook = codebook;
  return data;
}

}  // namespace cairn::testing
