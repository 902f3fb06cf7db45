#include "mapping/pairs/find_pairs.h"

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>

#include "core/parallel_for.h"
#include "core/require.h"
#include "engine/index/matching_index.h"
#include "ingest/codebook/shipped_codebook.h"
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

// All voters of a set in one index.
class Electorate {
 public:
  Electorate(const PhotoSet& set, const PairOptions& options)
      : options_(options), codec_(ShippedCodebook()), voters_(set.photos.size()) {
    std::vector<std::vector<uint8_t>> codes(set.photos.size());
    ParallelFor(static_cast<int>(set.photos.size()), options.num_threads, [&](int i) {
      if (!set.photos[i].keypoints.empty()) {
        voters_[i] = codec_.Project(VotersOf(set.photos[i], options.max_voters));
        codes[i] = codec_.Encode(voters_[i]);
      }
    });
    for (size_t i = 0; i < codes.size(); ++i) {
      codes_.insert(codes_.end(), codes[i].begin(), codes[i].end());
      photo_of_descriptor_.resize(photo_of_descriptor_.size() + voters_[i].rows(),
                                  static_cast<int>(i));
    }
    if (!codes_.empty()) {
      IndexOptions index_options;
      index_options.kind = IndexKind::kInvertedLists;
      index_ = MakeMatchingIndex(codec_.codebook(), codes_, index_options);
    }
  }

  // Votes of one photo's keypoints for each photo. `may_choose` says which photos count.
  template <typename MayChoose>
  std::vector<int> VotesOf(int photo, const MayChoose& may_choose) const {
    std::vector<int> votes(voters_.size(), 0);
    if (index_ == nullptr || voters_[photo].rows() == 0) {
      return votes;
    }
    std::vector<DescriptorHit> hits;
    index_->RangeSearch(voters_[photo], SameLandmarkDistance(codec_.codebook(), kDistanceQuantile),
                        &hits);
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
  const PairOptions& options_;
  DescriptorCodec codec_;
  std::vector<DescriptorMatrix> voters_;  // Of each photo, projected.
  std::vector<uint8_t> codes_;
  std::vector<int> photo_of_descriptor_;
  std::unique_ptr<const MatchingIndex> index_;
};

// Where photos may be, for the question whether two can show the same.
class Whereabouts {
 public:
  Whereabouts(const PhotoSet& set, const PairOptions& options)
      : max_distance_m_(options.max_distance_m) {
    for (const MappingPhoto& photo : set.photos) {
      x_in_ecef_.push_back(
          photo.gps ? std::optional(EcefFromGeodetic({photo.gps->lat_rad, photo.gps->lon_rad, 0.0}))
                    : std::nullopt);
      accuracy_m_.push_back(photo.gps_accuracy_m.value_or(options.default_accuracy_m));
    }
  }

  bool MayMeet(int a, int b) const {
    return !x_in_ecef_[a] || !x_in_ecef_[b] ||
           (*x_in_ecef_[a] - *x_in_ecef_[b]).norm() <=
               max_distance_m_ + accuracy_m_[a] + accuracy_m_[b];
  }

 private:
  double max_distance_m_;
  std::vector<std::optional<Eigen::Vector3d>> x_in_ecef_;  // On the ellipsoid.
  std::vector<double> accuracy_m_;
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

// The photos with the most votes, at most `count`; none without a vote.
std::vector<int> MostVoted(const std::vector<int>& votes, int count) {
  std::vector<int> photos;
  for (int i = 0; i < static_cast<int>(votes.size()); ++i) {
    if (votes[i] > 0) {
      photos.push_back(i);
    }
  }
  std::stable_sort(photos.begin(), photos.end(), [&](int p, int q) { return votes[p] > votes[q]; });
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
  const Electorate electorate(set, options);
  const Whereabouts whereabouts(set, options);
  std::vector<std::vector<int>> partners(num_photos);
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(num_photos, options.num_threads, [&](int photo) {
    const std::vector<int> votes = electorate.VotesOf(
        photo, [&](int other) { return other != photo && whereabouts.MayMeet(photo, other); });
    partners[photo] = MostVoted(votes, options.max_partners);
    if (progress) {
      const std::lock_guard lock(mutex);
      progress(++num_done, num_photos);
    }
  });
  std::set<std::pair<int, int>> pairs;
  for (int photo = 0; photo < num_photos; ++photo) {
    for (const int other : partners[photo]) {
      pairs.insert(std::minmax(photo, other));
    }
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace cairn
