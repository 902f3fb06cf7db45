#include "ingest/tiles/landmark_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/check.h"
#include "ingest/tiles/landmark_coverage.h"
#include "ingest/tiles/tile_option_visit.h"

namespace cairn {
namespace {

class ObservationCountSelector : public LandmarkSelector {
 public:
  explicit ObservationCountSelector(const LandmarkSelectionOptions& options) : options_(options) {
    options.Validate();
  }

  std::vector<uint32_t> Select(const VisibilityGraph& graph,
                               const std::vector<int>& num_descriptors) const override {
    CAIRN_CHECK(num_descriptors.size() == graph.num_landmarks(),
                "there must be one count for each landmark");
    std::vector<bool> kept(graph.num_landmarks(), false);
    const int64_t spent = SpendShares(graph, num_descriptors, &kept);
    SpendRest(graph, num_descriptors, spent, &kept);

    std::vector<uint32_t> selection;
    for (uint32_t i = 0; i < kept.size(); ++i) {
      if (kept[i]) {
        selection.push_back(i);
      }
    }
    return selection;
  }

 private:
  // Most observed first, then by index; those observed too rarely are left out.
  void Rank(const VisibilityGraph& graph, std::vector<uint32_t>* landmarks) const {
    std::erase_if(*landmarks, [&](uint32_t i) {
      return graph.num_observations[i] < options_.min_observations;
    });
    std::sort(landmarks->begin(), landmarks->end(), [&](uint32_t a, uint32_t b) {
      const double count_a = graph.num_observations[a];
      const double count_b = graph.num_observations[b];
      return count_a != count_b ? count_a > count_b : a < b;
    });
  }

  // Every keyframe's share is charged for all it keeps, also for what another keyframe keeps too,
  // so the sum stays within the budget. Returns what was spent, each landmark counted once.
  int64_t SpendShares(const VisibilityGraph& graph, const std::vector<int>& num_descriptors,
                      std::vector<bool>* kept) const {
    int64_t spent = 0;
    for (std::vector<uint32_t> landmarks : graph.landmarks_of_keyframe) {
      Rank(graph, &landmarks);
      int64_t share =
          options_.max_descriptors / static_cast<int64_t>(graph.landmarks_of_keyframe.size());
      for (const uint32_t i : landmarks) {
        share -= num_descriptors[i];
        if (share < 0) {
          break;
        }
        if (!(*kept)[i]) {
          spent += num_descriptors[i];
        }
        (*kept)[i] = true;
      }
    }
    return spent;
  }

  void SpendRest(const VisibilityGraph& graph, const std::vector<int>& num_descriptors,
                 int64_t spent, std::vector<bool>* kept) const {
    std::vector<uint32_t> landmarks(graph.num_landmarks());
    std::iota(landmarks.begin(), landmarks.end(), 0u);
    Rank(graph, &landmarks);
    for (const uint32_t i : landmarks) {
      if ((*kept)[i] || spent + num_descriptors[i] > options_.max_descriptors) {
        continue;
      }
      (*kept)[i] = true;
      spent += num_descriptors[i];
    }
  }

  LandmarkSelectionOptions options_;
};

class CoverageSelector : public LandmarkSelector {
 public:
  explicit CoverageSelector(const LandmarkSelectionOptions& options) : options_(options) {
    options.Validate();
  }

  std::vector<uint32_t> Select(const VisibilityGraph& graph,
                               const std::vector<int>& num_descriptors) const override {
    return SolveCoverage(graph, num_descriptors, options_).selection;
  }

 private:
  LandmarkSelectionOptions options_;
};

}  // namespace

void LandmarkSelectionOptions::Validate() const { CheckOptions("ingest.selection", *this); }

std::unique_ptr<LandmarkSelector> MakeObservationCountSelector(
    const LandmarkSelectionOptions& options) {
  return std::make_unique<ObservationCountSelector>(options);
}

std::unique_ptr<LandmarkSelector> MakeCoverageSelector(const LandmarkSelectionOptions& options) {
  return std::make_unique<CoverageSelector>(options);
}

std::unique_ptr<LandmarkSelector> MakeLandmarkSelector(const LandmarkSelectionOptions& options) {
  return options.kind == LandmarkSelectionKind::kCoverage ? MakeCoverageSelector(options)
                                                          : MakeObservationCountSelector(options);
}

}  // namespace cairn
