// Landmark and query descriptors with the statistics of projected SIFT. The descriptors form
// clusters, their variances fall over the dimensions, and same-landmark distances have a heavy
// tail.
#ifndef CAIRN_TESTS_ENGINE_SYNTHETIC_DESCRIPTORS_H_
#define CAIRN_TESTS_ENGINE_SYNTHETIC_DESCRIPTORS_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/features.h"
#include "engine/index/byte_descriptors.h"
#include "storage/codebook/codebook.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn::testing {

struct SyntheticDescriptorsOptions {
  int num_landmarks = 4000;
  int descriptors_per_landmark = 2;
  int num_queries = 400;  // Every second query shows a landmark of the tile.
  int dim = 16;
  int num_subspaces = 8;
  uint64_t seed = 1;
};

struct SyntheticDescriptors {
  static constexpr int kNoLandmark = -1;

  std::shared_ptr<const Codebook> codebook;
  std::vector<uint8_t> codes;  // Contiguous for each landmark, in the order of the landmarks.
  int descriptors_per_landmark = 0;
  DescriptorMatrix queries;
  std::vector<int> true_landmarks;  // One per query; kNoLandmark if it shows none.

  int LandmarkOf(uint32_t descriptor_idx) const {
    return static_cast<int>(descriptor_idx) / descriptors_per_landmark;
  }
};

class SyntheticDescriptorsBuilder {
 public:
  explicit SyntheticDescriptorsBuilder(const SyntheticDescriptorsOptions& options)
      : options_(options), random_(options.seed) {
    for (int i = 0; i < kNumClusters; ++i) {
      centers_.push_back(0.8f * RandomSpread());
    }
  }

  SyntheticDescriptors Build() {
    SyntheticDescriptors result;
    result.descriptors_per_landmark = options_.descriptors_per_landmark;
    DescriptorMatrix landmarks(options_.num_landmarks, options_.dim);
    for (int i = 0; i < options_.num_landmarks; ++i) {
      landmarks.row(i) = RandomDescriptor();
    }
    DescriptorMatrix observed(options_.num_landmarks * options_.descriptors_per_landmark,
                              options_.dim);
    for (int i = 0; i < observed.rows(); ++i) {
      observed.row(i) = Observe(landmarks.row(i / options_.descriptors_per_landmark));
    }
    auto codebook = std::make_shared<Codebook>(MakeCodebook(observed));
    result.codes = DescriptorCodec(codebook).Encode(observed);

    result.queries.resize(options_.num_queries, options_.dim);
    for (int i = 0; i < options_.num_queries; ++i) {
      const bool is_known = i % 2 == 0;
      const int landmark =
          is_known ? static_cast<int>(random_() % options_.num_landmarks) : result.kNoLandmark;
      result.queries.row(i) =
          Observe(is_known ? Eigen::RowVectorXf(landmarks.row(landmark)) : RandomDescriptor());
      result.true_landmarks.push_back(landmark);
    }
    codebook->same_landmark_distance_quantiles = SameLandmarkQuantiles(codebook, result);
    codebook->other_landmark_distance_quantiles = codebook->same_landmark_distance_quantiles;
    result.codebook = codebook;
    return result;
  }

 private:
  static constexpr int kNumClusters = 500;

  float Normal() { return normal_(random_); }

  Eigen::RowVectorXf RandomSpread() {
    Eigen::RowVectorXf spread(options_.dim);
    for (int j = 0; j < options_.dim; ++j) {
      spread[j] = 0.25f / std::sqrt(1.0f + 0.5f * static_cast<float>(j)) * Normal();
    }
    return spread;
  }

  Eigen::RowVectorXf RandomDescriptor() {
    return centers_[random_() % kNumClusters] + 0.6f * RandomSpread();
  }

  Eigen::RowVectorXf Observe(const Eigen::RowVectorXf& landmark) {
    const float sigma = 0.018f * std::exp(0.4f * Normal());
    Eigen::RowVectorXf observed = landmark;
    for (int j = 0; j < options_.dim; ++j) {
      observed[j] += sigma * Normal();
    }
    return observed;
  }

  // Words are parts of random descriptors, so that they are as dense as the data.
  Codebook MakeCodebook(const DescriptorMatrix& descriptors) {
    Codebook codebook;
    codebook.id = CodebookId{1};
    codebook.descriptor_type = "synthetic";
    codebook.normalization = DescriptorNormalization::kNone;
    codebook.mean = Eigen::VectorXf::Zero(options_.dim);
    codebook.projection = DescriptorMatrix::Identity(options_.dim, options_.dim);
    codebook.num_subspaces = options_.num_subspaces;
    const int sub_dim = options_.dim / options_.num_subspaces;
    for (int m = 0; m < options_.num_subspaces; ++m) {
      for (int w = 0; w < Codebook::kNumWords; ++w) {
        const auto row = static_cast<Eigen::Index>(random_() % descriptors.rows());
        for (int j = 0; j < sub_dim; ++j) {
          codebook.words.push_back(descriptors(row, m * sub_dim + j));
        }
      }
    }
    return codebook;
  }

  // Distances from the queries to the nearest quantized descriptor of their landmark.
  static std::vector<float> SameLandmarkQuantiles(const std::shared_ptr<const Codebook>& codebook,
                                                  const SyntheticDescriptors& data) {
    const DescriptorCodec codec(codebook);
    const int per_landmark = data.descriptors_per_landmark;
    std::vector<float> distances;
    for (size_t i = 0; i < data.true_landmarks.size(); ++i) {
      if (data.true_landmarks[i] != data.kNoLandmark) {
        const size_t first = size_t{1} * data.true_landmarks[i] * per_landmark;
        const DescriptorMatrix descriptors =
            codec.Decode(data.codes.data() + first * codebook->num_subspaces, per_landmark);
        distances.push_back(
            (descriptors.rowwise() - data.queries.row(i)).rowwise().norm().minCoeff());
      }
    }
    std::sort(distances.begin(), distances.end());
    std::vector<float> quantiles;
    for (size_t i = 1; i <= 19; ++i) {
      quantiles.push_back(distances[distances.size() * i / 20]);
    }
    return quantiles;
  }

  SyntheticDescriptorsOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<float> normal_;
  std::vector<Eigen::RowVectorXf> centers_;
};

inline SyntheticDescriptors MakeSyntheticDescriptors(const SyntheticDescriptorsOptions& options) {
  return SyntheticDescriptorsBuilder(options).Build();
}

// Returns the share of the queries with a true landmark for which that landmark is among the
// `max_neighbors` nearest landmarks of the hits.
inline double LandmarkRecall(const SyntheticDescriptors& data,
                             const std::vector<DescriptorHit>& hits, int max_neighbors) {
  constexpr float kNotFound = std::numeric_limits<float>::infinity();
  std::vector<float> true_sq_distances(data.true_landmarks.size(), kNotFound);
  for (const DescriptorHit& hit : hits) {
    if (data.LandmarkOf(hit.descriptor_idx) == data.true_landmarks[hit.query_idx]) {
      float& sq_distance = true_sq_distances[hit.query_idx];
      sq_distance = std::min(sq_distance, hit.sq_distance);
    }
  }
  std::vector<std::set<int>> closer_landmarks(data.true_landmarks.size());
  for (const DescriptorHit& hit : hits) {
    if (hit.sq_distance < true_sq_distances[hit.query_idx]) {
      closer_landmarks[hit.query_idx].insert(data.LandmarkOf(hit.descriptor_idx));
    }
  }
  int num_known = 0;
  int num_recalled = 0;
  for (size_t i = 0; i < data.true_landmarks.size(); ++i) {
    num_known += data.true_landmarks[i] != data.kNoLandmark ? 1 : 0;
    num_recalled += true_sq_distances[i] != kNotFound &&
                            closer_landmarks[i].size() < static_cast<size_t>(max_neighbors)
                        ? 1
                        : 0;
  }
  return static_cast<double>(num_recalled) / num_known;
}

// Distance below which nine tenths of a landmark's observations are.
inline double Threshold(const SyntheticDescriptors& data) {
  return SameLandmarkDistance(*data.codebook, 0.9);
}

inline std::vector<DescriptorHit> ExhaustiveHits(const SyntheticDescriptors& data) {
  std::vector<DescriptorHit> hits;
  ByteDescriptors(*data.codebook, data.codes).RangeSearch(data.queries, Threshold(data), &hits);
  return hits;
}

// Query, descriptor, squared distance.
using HitTuple = std::tuple<uint32_t, uint32_t, float>;

inline std::vector<HitTuple> Sorted(const std::vector<DescriptorHit>& hits) {
  std::vector<HitTuple> tuples;
  for (const DescriptorHit& hit : hits) {
    tuples.emplace_back(hit.query_idx, hit.descriptor_idx, hit.sq_distance);
  }
  std::sort(tuples.begin(), tuples.end());
  return tuples;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_SYNTHETIC_DESCRIPTORS_H_
