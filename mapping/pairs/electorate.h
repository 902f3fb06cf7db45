// The largest keypoints of photos vote for other photos. Private to mapping/pairs.
#ifndef CAIRN_MAPPING_PAIRS_ELECTORATE_H_
#define CAIRN_MAPPING_PAIRS_ELECTORATE_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/index/matching_index.h"
#include "mapping/pairs/find_pairs.h"
#include "mapping/photo_set.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {

// The voters of all photos, as codes of the shipped codebook.
class Voters {
 public:
  // Keeps references.
  Voters(const PhotoSet& set, const PairOptions& options);

  const Codebook& codebook() const { return codec_.codebook(); }
  // Projected. Computed each time: those of all photos would take more memory than their codes.
  DescriptorMatrix Of(int photo) const;
  // None without keypoints.
  const std::vector<uint8_t>& CodesOf(int photo) const { return codes_[photo]; }
  int CountOf(int photo) const;

 private:
  const PhotoSet& set_;
  const PairOptions& options_;
  DescriptorCodec codec_;
  std::vector<std::vector<uint8_t>> codes_;  // Of each photo.
};

// What one photo's voters say about another photo.
struct Ballot {
  int photo = 0;
  int votes = 0;      // Voters that have the other photo among their nearest neighbors.
  int num_alike = 0;  // Voters that look like some keypoint of the other photo.
};

// The voters of some photos in one index.
class Electorate {
 public:
  // `photos` ascend. Keeps references, but not to `photos`.
  Electorate(const Voters& voters, const std::vector<int>& photos, const PairOptions& options);

  // A ballot for each of the photos that gets votes, ascending. `may_choose` says which photos
  // count.
  std::vector<Ballot> VotesOf(int photo, const std::function<bool(int)>& may_choose) const;

 private:
  const Voters& voters_;
  const PairOptions& options_;
  std::vector<int> photos_;
  std::vector<uint8_t> codes_;
  std::vector<int> member_of_descriptor_;  // A place in photos_.
  std::unique_ptr<const MatchingIndex> index_;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_PAIRS_ELECTORATE_H_
