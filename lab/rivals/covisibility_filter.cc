#include "lab/rivals/covisibility_filter.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace cairn {
namespace {

// Disjoint sets of numbers that are joined pair by pair (Tarjan's union-find with path halving).
class DisjointSets {
 public:
  explicit DisjointSets(int size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }

  int Find(int i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  // The smaller number becomes the name of the set.
  void Join(int a, int b) {
    const auto [low, high] = std::minmax({Find(a), Find(b)});
    parent_[high] = low;
  }

 private:
  std::vector<int> parent_;
};

// Returns the number of distinct keypoints. Correspondences are ordered by keypoint.
double CountKeypoints(const std::vector<Correspondence>& correspondences,
                      const std::vector<int>& indices) {
  double count = 0.0;
  int last_keypoint_idx = -1;
  for (const int index : indices) {
    count += correspondences[index].keypoint_idx != last_keypoint_idx ? 1.0 : 0.0;
    last_keypoint_idx = correspondences[index].keypoint_idx;
  }
  return count;
}

}  // namespace

std::vector<PoseCandidate> CovisibilityCandidates(
    const std::vector<TileView>& tiles, const std::vector<Correspondence>& correspondences,
    const VotingOptions& options) {
  std::unordered_map<LandmarkId, int> numbers;  // One number per distinct landmark.
  std::vector<int> landmarks;                   // The number of each correspondence's landmark.
  for (const Correspondence& match : correspondences) {
    const TileLandmarks& tile = tiles[match.tile_idx].tile->landmarks();
    const LandmarkId id = tile.landmark_ids[match.landmark_idx];
    landmarks.push_back(numbers.try_emplace(id, static_cast<int>(numbers.size())).first->second);
  }
  DisjointSets sets(static_cast<int>(numbers.size()));
  for (const TileView& view : tiles) {
    // For each keyframe, a landmark that it saw.
    std::vector<int> seen(view.tile->covisibility().num_keyframes(), -1);
    for (const auto& [id, number] : numbers) {
      for (const uint32_t keyframe_idx : view.tile->landmark_keyframes().KeyframesThatSaw(id)) {
        if (seen[keyframe_idx] >= 0) {
          sets.Join(seen[keyframe_idx], number);
        }
        seen[keyframe_idx] = number;
      }
    }
  }
  std::vector<PoseCandidate> components(numbers.size());
  for (size_t i = 0; i < correspondences.size(); ++i) {
    components[sets.Find(landmarks[i])].correspondences.push_back(static_cast<int>(i));
  }
  for (PoseCandidate& component : components) {
    component.score = CountKeypoints(correspondences, component.correspondences);
  }
  std::erase_if(components, [&](const PoseCandidate& component) {
    return component.correspondences.empty() || component.score < options.min_score;
  });
  std::stable_sort(
      components.begin(), components.end(),
      [](const PoseCandidate& a, const PoseCandidate& b) { return a.score > b.score; });
  if (components.size() > static_cast<size_t>(options.max_candidates)) {
    components.resize(options.max_candidates);
  }
  return components;
}

VotingOptions WithCovisibility(VotingOptions options) {
  options.filter = OutlierFilter::kOther;
  options.other_filter = CovisibilityCandidates;
  return options;
}

}  // namespace cairn
