#include "core/scene/tracks.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

namespace cairn {
namespace {

// Disjoint sets of keypoints with at most one keypoint per image.
class KeypointSets {
 public:
  explicit KeypointSets(const std::vector<int>& num_keypoints) {
    for (size_t image = 0; image < num_keypoints.size(); ++image) {
      first_node_.push_back(static_cast<uint32_t>(parents_.size()));
      for (int i = 0; i < num_keypoints[image]; ++i) {
        parents_.push_back(static_cast<uint32_t>(parents_.size()));
        members_.push_back({{static_cast<int>(image), i}});
      }
    }
  }

  // Joins the two sets unless both contain a keypoint of the same image.
  void Join(const ReconObservation& p, const ReconObservation& q) {
    uint32_t large = Root(p), small = Root(q);
    if (large == small) {
      return;
    }
    if (members_[large].size() < members_[small].size()) {
      std::swap(large, small);
    }
    if (ShareImage(members_[large], members_[small])) {
      return;
    }
    std::vector<ReconObservation> merged;
    merged.reserve(members_[large].size() + members_[small].size());
    std::merge(members_[large].begin(), members_[large].end(), members_[small].begin(),
               members_[small].end(), std::back_inserter(merged), ByImage);
    members_[large] = std::move(merged);
    members_[small] = {};
    parents_[small] = large;
  }

  // Returns the sets in the order of their roots. Sets that were joined to others are empty.
  std::vector<std::vector<ReconObservation>> TakeMembers() && { return std::move(members_); }

 private:
  static bool ByImage(const ReconObservation& p, const ReconObservation& q) {
    return p.image_idx < q.image_idx;
  }

  static bool ShareImage(const std::vector<ReconObservation>& p,
                         const std::vector<ReconObservation>& q) {
    for (auto i = p.begin(), j = q.begin(); i != p.end() && j != q.end();) {
      if (i->image_idx == j->image_idx) {
        return true;
      }
      ByImage(*i, *j) ? ++i : ++j;
    }
    return false;
  }

  uint32_t Root(const ReconObservation& keypoint) {
    uint32_t node = first_node_[keypoint.image_idx] + static_cast<uint32_t>(keypoint.keypoint_idx);
    while (parents_[node] != node) {
      parents_[node] = parents_[parents_[node]];
      node = parents_[node];
    }
    return node;
  }

  std::vector<uint32_t> first_node_;  // Per image.
  std::vector<uint32_t> parents_;
  std::vector<std::vector<ReconObservation>> members_;  // By root; each ordered by image.
};

struct Edge {
  float distance;
  ReconObservation a, b;
};

}  // namespace

std::vector<std::vector<ReconObservation>> BuildTracks(const std::vector<PairMatches>& pairs,
                                                       const std::vector<int>& num_keypoints,
                                                       int min_length) {
  std::vector<Edge> edges;
  for (const PairMatches& pair : pairs) {
    for (const FeatureMatch& match : pair.matches) {
      edges.push_back(
          {match.distance, {pair.a_image_idx, match.a_idx}, {pair.b_image_idx, match.b_idx}});
    }
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& p, const Edge& q) { return p.distance < q.distance; });
  KeypointSets sets(num_keypoints);
  for (const Edge& edge : edges) {
    sets.Join(edge.a, edge.b);
  }
  std::vector<std::vector<ReconObservation>> tracks = std::move(sets).TakeMembers();
  std::erase_if(tracks, [&](const std::vector<ReconObservation>& track) {
    return static_cast<int>(track.size()) < min_length;
  });
  return tracks;
}

}  // namespace cairn
