// Which descriptors represent a landmark (paper, section "Appearance Summarization").
#ifndef CAIRN_INGEST_TILES_APPEARANCE_H_
#define CAIRN_INGEST_TILES_APPEARANCE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/features.h"

namespace cairn {

enum class AppearanceKind {
  kKMeans,    // Means of clusters: descriptors that nobody saw.
  kKMedoids,  // The members of clusters that are nearest to all others of theirs.
  kRandom,    // Any of the landmark's descriptors.
};

struct AppearanceOptions {
  AppearanceKind kind = AppearanceKind::kKMeans;  // Best in the paper.
  // If positive, every landmark gets this many descriptors (or all, if it has fewer); ratio,
  // min_count and max_count are ignored.
  int count = 0;
  double ratio = 0.25;  // Of the landmark's descriptors (paper: 25 %), at least min_count.
  int min_count = 1;
  int max_count = 16;
  uint64_t seed = 1;

  void Validate() const;
};

// The chosen appearances of one landmark.
struct AppearanceModes {
  DescriptorMatrix centers;             // num_modes x dim.
  std::vector<int> mode_of_descriptor;  // Parallel to the input rows.
};

// Interface of all summarizers. Thread-safe.
class AppearanceSummarizer {
 public:
  virtual ~AppearanceSummarizer() = default;
  // The most modes a landmark with that many descriptors gets.
  virtual int NumModes(int num_descriptors) const = 0;
  // descriptors: n x dim, projected, n > 0. Every mode has a member; equal descriptors may make for
  // fewer than NumModes. Deterministic: depends on the descriptors and options only.
  virtual AppearanceModes Summarize(const DescriptorMatrix& descriptors) const = 0;
};

// Cluster means in the projected space.
std::unique_ptr<AppearanceSummarizer> MakeKMeansSummarizer(const AppearanceOptions& options);

// Alternating k-medoids (Park and Jun 2009) under Euclidean distance, from the same start as
// k-means. Quadratic in the landmark's descriptors.
std::unique_ptr<AppearanceSummarizer> MakeKMedoidsSummarizer(const AppearanceOptions& options);

// A random subset; each descriptor belongs to the nearest of it. The baseline of the two above.
std::unique_ptr<AppearanceSummarizer> MakeRandomSummarizer(const AppearanceOptions& options);

// The one that `options.kind` names.
std::unique_ptr<AppearanceSummarizer> MakeAppearanceSummarizer(const AppearanceOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_APPEARANCE_H_
