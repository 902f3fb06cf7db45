#include "mapping/pairs/electorate.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/parallel_for.h"
#include "ingest/codebook/shipped_codebook.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// Distances of the descriptors of one landmark up to this quantile are looked at.
constexpr double kDistanceQuantile = 0.9;
// Keypoints look alike up to this quantile. Nearly as far as the other, there are descriptors of
// anything.
constexpr double kAlikeQuantile = 0.5;

constexpr uint32_t kNoVoter = std::numeric_limits<uint32_t>::max();

// The descriptors of a photo's largest keypoints.
DescriptorMatrix VotersOf(const MappingPhoto& photo, int max_voters) {
  std::vector<int> order(photo.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int p, int q) {
    return photo.keypoints[p].scale_px > photo.keypoints[q].scale_px;
  });
  order.resize(std::min<size_t>(order.size(), max_voters));
  const auto descriptors = photo.descriptors.Load();
  DescriptorMatrix voters(order.size(), descriptors->cols());
  for (size_t i = 0; i < order.size(); ++i) {
    voters.row(i) = descriptors->row(order[i]).cast<float>();
  }
  return voters;
}

}  // namespace

Voters::Voters(const PhotoSet& set, const PairOptions& options)
    : set_(set), options_(options), codec_(ShippedCodebook()), codes_(set.photos.size()) {
  ParallelFor(static_cast<int>(set.photos.size()), options.num_threads, [&](int i) {
    if (!set.photos[i].keypoints.empty()) {
      codes_[i] = codec_.Encode(Of(i));
    }
  });
}

DescriptorMatrix Voters::Of(int photo) const {
  return codec_.Project(VotersOf(set_.photos[photo], options_.max_voters));
}

int Voters::CountOf(int photo) const {
  return static_cast<int>(codes_[photo].size() / codebook().num_subspaces);
}

Electorate::Electorate(const Voters& voters, const std::vector<int>& photos,
                       const PairOptions& options)
    : voters_(voters), options_(options), photos_(photos) {
  for (size_t member = 0; member < photos_.size(); ++member) {
    const std::vector<uint8_t>& codes = voters.CodesOf(photos_[member]);
    codes_.insert(codes_.end(), codes.begin(), codes.end());
    member_of_descriptor_.resize(member_of_descriptor_.size() + voters.CountOf(photos_[member]),
                                 static_cast<int>(member));
  }
  if (!codes_.empty()) {
    IndexOptions index_options;
    index_options.kind = IndexKind::kInvertedLists;
    index_ = MakeMatchingIndex(voters.codebook(), codes_, index_options);
  }
}

std::vector<Ballot> Electorate::VotesOf(int photo,
                                        const std::function<bool(int)>& may_choose) const {
  std::vector<Ballot> ballots;
  if (index_ == nullptr || voters_.CountOf(photo) == 0) {
    return ballots;
  }
  std::vector<uint8_t> counts(photos_.size());
  for (size_t member = 0; member < photos_.size(); ++member) {
    counts[member] = may_choose(photos_[member]) ? 1 : 0;
  }
  std::vector<DescriptorHit> hits;
  index_->RangeSearch(voters_.Of(photo),
                      SameLandmarkDistance(voters_.codebook(), kDistanceQuantile), &hits);
  const double alike = SameLandmarkDistance(voters_.codebook(), kAlikeQuantile);
  std::vector<Ballot> of_member(photos_.size());
  std::vector<uint32_t> last_vote(photos_.size(), kNoVoter), last_alike(photos_.size(), kNoVoter);
  const auto count = [&](const DescriptorHit& hit, int Ballot::*number,
                         std::vector<uint32_t>* last) {
    const int member = member_of_descriptor_[hit.descriptor_idx];
    if ((*last)[member] != hit.query_idx) {
      (*last)[member] = hit.query_idx;
      ++(of_member[member].*number);
    }
  };
  for (auto begin = hits.begin(); begin != hits.end();) {
    const auto end = std::find_if(begin, hits.end(), [&](const DescriptorHit& hit) {
      return hit.query_idx != begin->query_idx;
    });
    const auto wanted = std::partition(begin, end, [&](const DescriptorHit& hit) {
      return counts[member_of_descriptor_[hit.descriptor_idx]] != 0;
    });
    const auto last =
        begin + std::min<std::ptrdiff_t>(wanted - begin, options_.neighbors_per_voter);
    std::partial_sort(begin, last, wanted, [](const DescriptorHit& p, const DescriptorHit& q) {
      return std::pair(p.sq_distance, p.descriptor_idx) <
             std::pair(q.sq_distance, q.descriptor_idx);
    });
    for (auto hit = begin; hit != last; ++hit) {
      count(*hit, &Ballot::votes, &last_vote);
    }
    for (auto hit = begin; hit != wanted; ++hit) {
      if (hit->sq_distance <= alike * alike) {
        count(*hit, &Ballot::num_alike, &last_alike);
      }
    }
    begin = end;
  }
  for (size_t member = 0; member < photos_.size(); ++member) {
    if (of_member[member].votes > 0) {
      of_member[member].photo = photos_[member];
      ballots.push_back(of_member[member]);
    }
  }
  return ballots;
}

}  // namespace cairn
