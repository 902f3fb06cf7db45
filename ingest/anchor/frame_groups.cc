#include "ingest/anchor/frame_groups.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "core/check.h"

namespace cairn {
namespace {

constexpr double kSeamM = 10.0;
constexpr double kSeamShare = 0.5;

class Grouping {
 public:
  Grouping(size_t num_frames, std::vector<FramePair> pairs)
      : pairs_(std::move(pairs)), of_pair_(num_frames * num_frames) {
    for (size_t i = 0; i < num_frames; ++i) {
      group_of_.push_back(i);
      members_.push_back({i});
    }
    for (const FramePair& pair : pairs_) {
      CAIRN_CHECK(pair.a < num_frames && pair.b < num_frames, "pairs are of frames");
      of_pair_[pair.a * num_frames + pair.b] = {pair.distance_m, pair.agree};
      of_pair_[pair.b * num_frames + pair.a] = {pair.distance_m, pair.agree};
    }
    std::sort(pairs_.begin(), pairs_.end(), [](const FramePair& p, const FramePair& q) {
      return std::tie(p.distance_m, p.a, p.b) < std::tie(q.distance_m, q.a, q.b);
    });
  }

  std::vector<std::vector<size_t>> Run() {
    while (Sweep()) {
    }
    std::vector<std::vector<size_t>> groups;
    for (std::vector<size_t>& members : members_) {
      if (!members.empty()) {
        std::sort(members.begin(), members.end());
        groups.push_back(std::move(members));
      }
    }
    return groups;
  }

 private:
  struct Relation {
    double distance_m = std::numeric_limits<double>::infinity();  // Of frames that are not near.
    bool agree = false;
  };

  // Returns whether any groups were joined.
  bool Sweep() {
    // The sizes that two groups had when they were not joined: they are asked again if one has
    // grown.
    std::map<std::pair<size_t, size_t>, std::pair<size_t, size_t>> refused;
    bool any = false;
    for (const FramePair& pair : pairs_) {
      const auto [a, b] = std::minmax({group_of_[pair.a], group_of_[pair.b]});
      if (a == b) {
        continue;
      }
      std::pair<size_t, size_t>& sizes = refused[{a, b}];
      if (sizes == std::pair(members_[a].size(), members_[b].size())) {
        continue;
      }
      if (MostAgreeAtSeam(members_[a], members_[b])) {
        Join(a, b);
        any = true;
      } else {
        sizes = {members_[a].size(), members_[b].size()};
      }
    }
    return any;
  }

  const Relation& Of(size_t a, size_t b) const { return of_pair_[a * group_of_.size() + b]; }

  bool MostAgreeAtSeam(const std::vector<size_t>& as, const std::vector<size_t>& bs) const {
    double shortest_m = std::numeric_limits<double>::infinity();
    for (const size_t a : as) {
      for (const size_t b : bs) {
        shortest_m = std::min(shortest_m, Of(a, b).distance_m);
      }
    }
    const double longest_m = shortest_m + std::max(kSeamM, kSeamShare * shortest_m);
    int balance = 0;
    for (const size_t a : as) {
      for (const size_t b : bs) {
        if (Of(a, b).distance_m <= longest_m) {
          balance += Of(a, b).agree ? 1 : -1;
        }
      }
    }
    return balance > 0;
  }

  void Join(size_t into, size_t from) {
    for (const size_t i : members_[from]) {
      group_of_[i] = into;
    }
    members_[into].insert(members_[into].end(), members_[from].begin(), members_[from].end());
    members_[from].clear();
  }

  std::vector<FramePair> pairs_;
  std::vector<Relation> of_pair_;  // A row for each frame.
  std::vector<size_t> group_of_;
  std::vector<std::vector<size_t>> members_;  // Of each group; none of one that joined another.
};

}  // namespace

std::vector<std::vector<size_t>> GroupFrames(size_t num_frames, std::vector<FramePair> pairs) {
  return Grouping(num_frames, std::move(pairs)).Run();
}

}  // namespace cairn
