// Measures how the load of an inverted multi-index' buckets grows with the tile.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel_for.h"
#include "engine/index/byte_descriptors.h"
#include "engine/index/product_words.h"
#include "lab/experiments/runs/descriptor_looks.h"
#include "lab/experiments/runs/runs.h"
#include "lab/rivals/index_methods.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kLooksOfALandmark = 5;
constexpr double kMinSlope = 0.7, kMaxSlope = 1.3;  // "Roughly linear".
constexpr double kUnevenRatio = 10.0;
constexpr int kEncodeLandmarks = 2'000;

struct Load {
  double mean = 0.0;  // Descriptors per filled bucket.
  double max = 0.0;
  double filled_share = 0.0;  // Share of the buckets.
  // Share of the descriptors that is in the fullest hundredth of the filled buckets.
  double top_share = 0.0;
};

// The loads at each size, for one repeat.
using Repeat = std::vector<Load>;

// Returns the codes of `num_descriptors / kLooksOfALandmark` landmarks' descriptors. Works in
// pieces that fit the cache.
std::vector<uint8_t> MakeCodes(const DescriptorLooks& looks, const DescriptorCodec& codec,
                               uint64_t first_landmark, int num_descriptors) {
  std::vector<uint8_t> codes;
  const int num_landmarks = num_descriptors / kLooksOfALandmark;
  for (int done = 0; done < num_landmarks; done += kEncodeLandmarks) {
    const int count = std::min(kEncodeLandmarks, num_landmarks - done);
    const auto piece =
        codec.Encode(codec.Project(looks.ByCar(first_landmark + done, count, kLooksOfALandmark)));
    codes.insert(codes.end(), piece.begin(), piece.end());
  }
  return codes;
}

Load MeasureLoad(const Codebook& codebook, std::span<const uint8_t> codes,
                 const InvertedMultiIndexOptions& options) {
  const ByteDescriptors descriptors(codebook, codes);
  const ProductWords words(descriptors, options.num_words, options.num_iterations, options.seed);
  std::vector<uint32_t> sizes(words.num_cells(), 0);
  for (const uint32_t cell : words.NearestCells(descriptors)) {
    ++sizes[cell];
  }
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  const auto num_filled =
      static_cast<size_t>(std::find(sizes.begin(), sizes.end(), 0u) - sizes.begin());
  double in_top = 0.0;
  for (size_t i = 0; i < std::max<size_t>(1, num_filled / 100); ++i) {
    in_top += sizes[i];
  }
  const auto num_descriptors = static_cast<double>(descriptors.size());
  return {num_descriptors / static_cast<double>(num_filled), static_cast<double>(sizes.front()),
          static_cast<double>(num_filled) / static_cast<double>(sizes.size()),
          in_top / num_descriptors};
}

// Returns the mean of a measure over the repeats, with its interval.
Interval OverRepeats(const std::vector<Repeat>& repeats,
                     const std::function<double(const Repeat&)>& measure) {
  return Bootstrap(repeats.size(), [&](std::span<const size_t> sample) {
    double sum = 0.0;
    for (const size_t i : sample) {
      sum += measure(repeats[i]);
    }
    return sum / static_cast<double>(sample.size());
  });
}

// Returns the exponent of the load's growth with the size, from the smallest to the largest tile.
double Slope(const std::vector<int>& sizes, const Repeat& repeat, double Load::*load) {
  return std::log(repeat.back().*load / (repeat.front().*load)) /
         std::log(static_cast<double>(sizes.back()) / sizes.front());
}

constexpr struct {
  const char* name;
  double Load::*load;
} kLoads[] = {{"mean_load", &Load::mean},
              {"max_load", &Load::max},
              {"filled_share", &Load::filled_share},
              {"share_in_fullest_1_percent", &Load::top_share}};

void FillOutcome(const std::vector<int>& sizes, const std::vector<Repeat>& repeats,
                 ExperimentOutcome* outcome) {
  std::vector<Column> columns = {{"descriptors"}};
  for (const auto& [name, load] : kLoads) {
    AddIntervalColumns(name, &columns);
  }
  outcome->table = ResultTable(std::move(columns));
  Figure figure{"06_bucket_load", "Bucket load of the inverted multi-index",
                "descriptors of the tile", "descriptors in a bucket"};
  figure.log_x = figure.log_y = true;
  figure.series = {{"mean of filled buckets", {}}, {"fullest bucket", {}}};
  for (size_t i = 0; i < sizes.size(); ++i) {
    std::vector<Cell> row = {static_cast<double>(sizes[i])};
    std::vector<Interval> intervals;
    for (const auto& named : kLoads) {
      intervals.push_back(
          OverRepeats(repeats, [&](const Repeat& repeat) { return repeat[i].*(named.load); }));
      AddIntervalCells(intervals.back(), &row);
    }
    figure.series[0].points.push_back({static_cast<double>(sizes[i]), intervals[0]});
    figure.series[1].points.push_back({static_cast<double>(sizes[i]), intervals[1]});
    outcome->table.AddRow(std::move(row));
  }
  outcome->figures = {figure};
}

ExperimentOutcome RunBucketLoad(const ExperimentContext& context) {
  const auto sizes =
      context.Pick<std::vector<int>>({5'000, 20'000}, {50'000, 100'000, 200'000, 500'000});
  const int num_repeats = context.Pick(2, 4);
  InvertedMultiIndexOptions options;
  options.num_words = context.Pick(100, options.num_words);
  CodebookOptions codebook_options;
  codebook_options.seed = context.seed;
  codebook_options.max_training_descriptors =
      context.Pick(3'000, codebook_options.max_training_descriptors);
  const DescriptorLooks looks(context.seed);
  const auto codebook = std::make_shared<const Codebook>(looks.Train(codebook_options));
  const DescriptorCodec codec(codebook);
  std::vector<Repeat> repeats(num_repeats);
  ParallelFor(num_repeats, context.num_threads, [&](int r) {
    const std::vector<uint8_t> codes =
        MakeCodes(looks, codec, uint64_t(r) * uint64_t(sizes.back()), sizes.back());
    for (const int size : sizes) {
      repeats[r].push_back(MeasureLoad(
          *codebook, std::span(codes).first(size_t(size) * codebook->num_subspaces), options));
    }
  });
  const auto slope =
      OverRepeats(repeats, [&](const Repeat& repeat) { return Slope(sizes, repeat, &Load::max); });
  const auto unevenness = OverRepeats(
      repeats, [](const Repeat& repeat) { return repeat.back().max / repeat.back().mean; });
  const auto filled =
      OverRepeats(repeats, [](const Repeat& repeat) { return repeat.back().filled_share; });

  ExperimentOutcome outcome;
  outcome.parameters = {{"words of each half", fmt::format("{}", options.num_words)},
                        {"repeats", fmt::format("{}", num_repeats)},
                        {"looks a landmark", fmt::format("{}", kLooksOfALandmark)}};
  FillOutcome(sizes, repeats, &outcome);
  outcome.verdict = JudgeAll({JudgeGreater(slope, kMinSlope),
                              JudgeGreater({-slope.value, -slope.high, -slope.low}, -kMaxSlope),
                              JudgeGreater(unevenness, kUnevenRatio)});
  outcome.sentence = fmt::format(
      "The load of the fullest bucket grows as the number of descriptors to the power of {}. At {} "
      "descriptors the fullest bucket is {} times as full as the mean filled bucket, and {} of all "
      "buckets are filled.",
      IntervalText(slope, 2), sizes.back(), IntervalText(unevenness, 1), IntervalText(filled, 2));
  return outcome;
}

}  // namespace

Experiment BucketLoadExperiment() {
  return {
      "06_bucket_load",
      "Bucket load of the inverted multi-index",
      "Figure 7",
      "The mean and the maximum load of the buckets grow about linearly with the descriptors of a "
      "tile. The load stays very uneven: only about 30 % of the product words occur.",
      "holds if the load of the fullest bucket grows as a power between 0.7 and 1.3 of the tile's "
      "descriptors and is more than ten times that of the mean filled bucket, by intervals over "
      "repeats; does not hold if an interval contradicts one of these conditions.",
      "1 min",
      RunBucketLoad};
}

}  // namespace cairn
