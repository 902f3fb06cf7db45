#include "mapping/pairs/find_pairs.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>

#include "core/parallel_for.h"
#include "core/require.h"
#include "engine/index/matching_index.h"
#include "ingest/codebook/shipped_codebook.h"
#include "mapping/pairs/divide_polls.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// Distances of the descriptors of one landmark up to this quantile are looked at.
constexpr double kDistanceQuantile = 0.9;

// The descriptors of a photo's largest keypoints.
DescriptorMatrix VotersOf(const MappingPhoto& photo, int max_voters) {
  std::vector<int> order(photo.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int p, int q) {
    return photo.keypoints[p].scale_px > photo.keypoints[q].scale_px;
  });
  order.resize(std::min<size_t>(order.size(), max_voters));
  DescriptorMatrix voters(order.size(), photo.descriptors.cols());
  for (size_t i = 0; i < order.size(); ++i) {
    voters.row(i) = photo.descriptors.row(order[i]).cast<float>();
  }
  return voters;
}

// The voters of all photos, as codes.
class Voters {
 public:
  Voters(const PhotoSet& set, const PairOptions& options)
      : set_(set), options_(options), codec_(ShippedCodebook()), codes_(set.photos.size()) {
    ParallelFor(static_cast<int>(set.photos.size()), options.num_threads, [&](int i) {
      if (!set.photos[i].keypoints.empty()) {
        codes_[i] = codec_.Encode(Of(i));
      }
    });
  }

  const Codebook& codebook() const { return codec_.codebook(); }
  // Projected. Computed each time: those of all photos would take more memory than their codes.
  DescriptorMatrix Of(int photo) const {
    return codec_.Project(VotersOf(set_.photos[photo], options_.max_voters));
  }
  const std::vector<uint8_t>& CodesOf(int photo) const { return codes_[photo]; }

 private:
  const PhotoSet& set_;
  const PairOptions& options_;
  DescriptorCodec codec_;
  std::vector<std::vector<uint8_t>> codes_;  // Of each photo; none without keypoints.
};

// The voters of some photos in one index.
class Electorate {
 public:
  // `photos` ascend.
  Electorate(const Voters& voters, const std::vector<int>& photos, const PairOptions& options)
      : voters_(voters), options_(options) {
    for (const int photo : photos) {
      const std::vector<uint8_t>& codes = voters.CodesOf(photo);
      codes_.insert(codes_.end(), codes.begin(), codes.end());
      photo_of_descriptor_.resize(codes_.size() / voters.codebook().num_subspaces, photo);
    }
    if (!codes_.empty()) {
      IndexOptions index_options;
      index_options.kind = IndexKind::kInvertedLists;
      index_ = MakeMatchingIndex(voters.codebook(), codes_, index_options);
    }
  }

  // Votes of one photo's keypoints for each photo that has any. `may_choose` says which photos
  // count.
  template <typename MayChoose>
  std::map<int, int> VotesOf(int photo, const MayChoose& may_choose) const {
    std::map<int, int> votes;
    if (index_ == nullptr || voters_.CodesOf(photo).empty()) {
      return votes;
    }
    std::vector<DescriptorHit> hits;
    index_->RangeSearch(voters_.Of(photo),
                        SameLandmarkDistance(voters_.codebook(), kDistanceQuantile), &hits);
    for (auto begin = hits.begin(); begin != hits.end();) {
      const auto end = std::find_if(begin, hits.end(), [&](const DescriptorHit& hit) {
        return hit.query_idx != begin->query_idx;
      });
      const auto wanted = std::partition(begin, end, [&](const DescriptorHit& hit) {
        return may_choose(photo_of_descriptor_[hit.descriptor_idx]);
      });
      const auto last =
          begin + std::min<std::ptrdiff_t>(wanted - begin, options_.neighbors_per_voter);
      std::partial_sort(begin, last, wanted, [](const DescriptorHit& p, const DescriptorHit& q) {
        return std::pair(p.sq_distance, p.descriptor_idx) <
               std::pair(q.sq_distance, q.descriptor_idx);
      });
      std::set<int> photos;
      for (auto hit = begin; hit != last; ++hit) {
        photos.insert(photo_of_descriptor_[hit->descriptor_idx]);
      }
      for (const int chosen : photos) {
        ++votes[chosen];
      }
      begin = end;
    }
    return votes;
  }

 private:
  const Voters& voters_;
  const PairOptions& options_;
  std::vector<uint8_t> codes_;
  std::vector<int> photo_of_descriptor_;
  std::unique_ptr<const MatchingIndex> index_;
};

std::vector<std::pair<int, int>> AllPairs(int num_photos) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < num_photos; ++a) {
    for (int b = a + 1; b < num_photos; ++b) {
      pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

// The photos with the most votes, at most `count`.
std::vector<int> MostVoted(const std::map<int, int>& votes, int count) {
  std::vector<int> photos;
  for (const auto& [photo, number] : votes) {
    photos.push_back(photo);
  }
  std::stable_sort(photos.begin(), photos.end(),
                   [&](int p, int q) { return votes.at(p) > votes.at(q); });
  photos.resize(std::min<size_t>(photos.size(), count));
  return photos;
}

}  // namespace

void PairOptions::Validate() const {
  RequireWithin("pairs.max_partners", max_partners, 2, 1000);
  RequireWithin("pairs.max_exhaustive", max_exhaustive, 0, 1000);
  RequireWithin("pairs.max_voters", max_voters, 10, 100'000);
  RequireWithin("pairs.neighbors_per_voter", neighbors_per_voter, 1, 100);
  RequireWithin("pairs.max_distance_m", max_distance_m, 0.0, 1e6);
  RequireWithin("pairs.default_accuracy_m", default_accuracy_m, 0.0, 1e6);
  RequireWithin("pairs.num_threads", num_threads, 1, 1024);
}

std::vector<std::pair<int, int>> FindPairs(
    const PhotoSet& set, const PairOptions& options,
    const std::function<void(int done, int total)>& progress) {
  options.Validate();
  const int num_photos = static_cast<int>(set.photos.size());
  if (num_photos <= options.max_exhaustive) {
    return AllPairs(num_photos);
  }
  const Voters voters(set, options);
  const Whereabouts whereabouts(set, options);
  std::vector<std::vector<int>> partners(num_photos);
  std::mutex mutex;
  int num_done = 0;
  for (const Poll& poll : DividePolls(whereabouts, num_photos)) {
    const Electorate electorate(voters, poll.candidates, options);
    ParallelFor(static_cast<int>(poll.photos.size()), options.num_threads, [&](int i) {
      const int photo = poll.photos[i];
      const std::map<int, int> votes = electorate.VotesOf(
          photo, [&](int other) { return other != photo && whereabouts.MayMeet(photo, other); });
      partners[photo] = MostVoted(votes, options.max_partners);
      if (progress) {
        const std::lock_guard lock(mutex);
        progress(++num_done, num_photos);
      }
    });
  }
  std::set<std::pair<int, int>> pairs;
  for (int photo = 0; photo < num_photos; ++photo) {
    for (const int other : partners[photo]) {
      pairs.insert(std::minmax(photo, other));
    }
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace cairn
