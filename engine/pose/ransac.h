// Locally optimized RANSAC (Chum, Matas, Kittler, DAGM 2003), one loop for all problems.
#ifndef CAIRN_ENGINE_POSE_RANSAC_H_
#define CAIRN_ENGINE_POSE_RANSAC_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/random.h"

namespace cairn {

struct RansacOptions {
  int min_iterations = 50;
  int max_iterations = 2000;
  // Sampling stops once a sample free of outliers was drawn with this probability.
  double success_probability = 0.999;
  // Models with a lower score are not needed.
  double min_score = 0.0;
};

template <typename Model>
struct RansacResult {
  std::optional<Model> model;  // The best optimized model; empty if no sample gave one.
  double score = 0.0;
  int num_iterations = 0;
};

// Returns the number of iterations after which a sample without outliers has been drawn with
// `success_probability`, if each sample is free of outliers with `inlier_sample_probability`.
// Clamped to the bounds of the options.
inline int RequiredIterations(double inlier_sample_probability, const RansacOptions& options) {
  const double log_miss = std::log1p(-std::clamp(inlier_sample_probability, 0.0, 1.0 - 1e-12));
  const double needed =
      log_miss < 0.0 ? std::ceil(std::log1p(-options.success_probability) / log_miss) : 1e18;
  return static_cast<int>(std::clamp(needed, static_cast<double>(options.min_iterations),
                                     static_cast<double>(options.max_iterations)));
}

// Runs the RANSAC loop. A Problem provides the following, where Model is a copyable type of its
// own:
//
//   static constexpr int kMaxModels;
//     The largest number of models that one minimal sample gives.
//   int SampleModels(Random* random, std::array<Model, kMaxModels>* models);
//     Draws a minimal sample, solves it, and returns the number of models.
//   double ScoreMinimal(const Model& model, double score_to_beat);
//     Returns the score of a minimal model; higher is better, 0 is worthless. May stop early and
//     return any value not above `score_to_beat` once the model is unlikely to beat it.
//   std::optional<std::pair<Model, double>> Optimize(const Model& model);
//     Local optimization: returns a better model near `model` and its final score, which is
//     comparable among optimized models only. Returns nothing if the optimization fails.
//   double InlierSampleProbability(const Model& model);
//     Returns the probability that a minimal sample contains only inliers of the optimized `model`.
//   double SampleProbabilityOfScore(double score);
//     Returns the same probability for a model of which only the score is known.
//
// With a min_score, the loop ends once a model of that score would have been found. So if a good
// model is already known, searches for others stay short. Deterministic by seed.
template <typename Problem>
RansacResult<typename Problem::Model> LoRansac(Problem* problem, const RansacOptions& options,
                                               uint64_t seed) {
  using Model = typename Problem::Model;
  RansacResult<Model> best;
  Random random(seed);
  std::array<Model, Problem::kMaxModels> models;
  double best_minimal_score = options.min_score;
  int num_required =
      options.min_score > 0.0
          ? RequiredIterations(problem->SampleProbabilityOfScore(options.min_score), options)
          : options.max_iterations;
  while (best.num_iterations < num_required) {
    ++best.num_iterations;
    const int num_models = problem->SampleModels(&random, &models);
    for (int i = 0; i < num_models; ++i) {
      const double minimal_score = problem->ScoreMinimal(models[i], best_minimal_score);
      if (minimal_score <= best_minimal_score) {
        continue;
      }
      best_minimal_score = minimal_score;
      const auto optimized = problem->Optimize(models[i]);
      if (optimized && optimized->second > best.score) {
        best.model = optimized->first;
        best.score = optimized->second;
        num_required = std::min(
            num_required,
            RequiredIterations(problem->InlierSampleProbability(optimized->first), options));
      }
    }
  }
  return best;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_RANSAC_H_
