#include "ingest/tiles/merge_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/check.h"
#include "core/statistics.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/tile_option_visit.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// One descriptor of a landmark with its attributes; `code` is empty once it was averaged.
struct WeightedDescriptor {
  Eigen::RowVectorXf descriptor;
  std::vector<uint8_t> code;
  double weight = 0.0;
  std::optional<double> orientation_rad;
  std::optional<double> log_size;
  double azimuth_rad = 0.0;
};

// Mean direction of two angles with weights; the first one if they cancel.
double MeanAngleRad(double a_rad, double a_weight, double b_rad, double b_weight) {
  CircularMean mean;
  mean.Add(a_rad, a_weight);
  mean.Add(b_rad, b_weight);
  return mean.AngleRad().value_or(a_rad);
}

WeightedDescriptor MeanDescriptor(const WeightedDescriptor& a, const WeightedDescriptor& b) {
  WeightedDescriptor mean;
  mean.weight = a.weight + b.weight;
  const double a_share = a.weight / mean.weight, b_share = b.weight / mean.weight;
  mean.descriptor =
      static_cast<float>(a_share) * a.descriptor + static_cast<float>(b_share) * b.descriptor;
  mean.log_size = a.log_size ? a.log_size : b.log_size;
  if (a.log_size && b.log_size) {
    mean.log_size = a_share * *a.log_size + b_share * *b.log_size;
  }
  mean.azimuth_rad = MeanAngleRad(a.azimuth_rad, a_share, b.azimuth_rad, b_share);
  mean.orientation_rad = a.orientation_rad ? a.orientation_rad : b.orientation_rad;
  if (a.orientation_rad && b.orientation_rad) {
    mean.orientation_rad = MeanAngleRad(*a.orientation_rad, a_share, *b.orientation_rad, b_share);
  }
  return mean;
}

// The nearest two of a landmark's descriptors, again and again as descriptors are averaged.
// Remembers for each descriptor the nearest of those behind it. Of equally near pairs, it takes the
// first. Usually quadratic in the descriptors.
class NearestPairs {
 public:
  explicit NearestPairs(std::vector<WeightedDescriptor>* weighted)
      : weighted_(*weighted), partners_(weighted->size()), is_gone_(weighted->size(), false) {
    for (size_t i = 0; i < partners_.size(); ++i) {
      FindPartner(i);
    }
  }

  // Replaces pairs by their means, until no pair is within the distance.
  void AverageWithin(float max_sq_distance) {
    while (const std::optional<size_t> first = FirstOfNearestPair()) {
      const Partner nearest = partners_[*first];
      if (nearest.sq_distance > max_sq_distance) {
        break;
      }
      weighted_[*first] = MeanDescriptor(weighted_[*first], weighted_[nearest.idx]);
      is_gone_[nearest.idx] = true;
      FindPartner(*first);
      for (size_t i = 0; i < nearest.idx; ++i) {
        NoteChange(i, *first, nearest.idx);
      }
    }
    size_t num_left = 0;
    for (size_t i = 0; i < weighted_.size(); ++i) {
      if (!is_gone_[i] && num_left++ != i) {
        weighted_[num_left - 1] = std::move(weighted_[i]);
      }
    }
    weighted_.resize(num_left);
  }

 private:
  struct Partner {
    size_t idx = 0;
    // If stale, no descriptor behind is nearer than this, but none need be as near.
    float sq_distance = std::numeric_limits<float>::max();
    bool is_stale = false;
  };

  float SqDistance(size_t i, size_t j) const {
    return (weighted_[i].descriptor - weighted_[j].descriptor).squaredNorm();
  }

  void FindPartner(size_t i) {
    Partner nearest;
    for (size_t j = i + 1; j < weighted_.size(); ++j) {
      if (is_gone_[j]) {
        continue;
      }
      const float sq_distance = SqDistance(i, j);
      if (sq_distance < nearest.sq_distance) {
        nearest = {j, sq_distance};
      }
    }
    partners_[i] = nearest;
  }

  // Returns nothing if at most one descriptor is left. A stale partner is sought again only when
  // its bound is the least, so that an average that many had as their partner does not cost a
  // search for each of them.
  std::optional<size_t> FirstOfNearestPair() {
    while (true) {
      std::optional<size_t> first;
      for (size_t i = 0; i < partners_.size(); ++i) {
        const float least =
            first ? partners_[*first].sq_distance : std::numeric_limits<float>::max();
        if (!is_gone_[i] && partners_[i].sq_distance < least) {
          first = i;
        }
      }
      if (!first || !partners_[*first].is_stale) {
        return first;
      }
      FindPartner(*first);
    }
  }

  // Notes that descriptor `mean` has moved and `gone` is no more.
  void NoteChange(size_t i, size_t mean, size_t gone) {
    Partner& partner = partners_[i];
    if (is_gone_[i] || i == mean) {
      return;
    }
    const bool had_either = partner.idx == mean || partner.idx == gone;
    if (i < mean) {
      const float sq_distance = SqDistance(i, mean);
      const bool is_nearer = sq_distance < partner.sq_distance ||
                             (sq_distance == partner.sq_distance && mean <= partner.idx);
      if (is_nearer) {
        // Of a stale partner, the bound stands for descriptors in front of `mean`, too.
        partner = {mean, sq_distance, partner.is_stale && sq_distance == partner.sq_distance};
        return;
      }
    }
    partner.is_stale = partner.is_stale || had_either;
  }

  std::vector<WeightedDescriptor>& weighted_;
  std::vector<Partner> partners_;
  std::vector<bool> is_gone_;
};

class TileMerger {
 public:
  TileMerger(const Tile& known, const Tile& fresh, const DescriptorCodec& codec,
             const AppearanceSummarizer& summarizer, const MergeOptions& options)
      : known_(known), fresh_(fresh), codec_(codec), summarizer_(summarizer), options_(options) {
    CAIRN_CHECK(known.id == fresh.id && known.codebook_id == fresh.codebook_id,
                "only contents of one tile in one codebook can be merged");
    const double median = SameLandmarkDistance(codec.codebook(), 0.5);
    max_same_sq_distance_ = static_cast<float>(std::pow(options.same_look_share * median, 2));
  }

  Tile Merge() {
    std::unordered_map<uint64_t, uint32_t> fresh_of_id;
    for (uint32_t i = 0; i < fresh_.num_landmarks(); ++i) {
      fresh_of_id.emplace(Value(fresh_.landmark_ids[i]), i);
    }
    merged_ = EmptyTile(known_.id, known_.codebook_id, known_.code_size);
    new_idx_of_fresh_.resize(fresh_.num_landmarks());
    std::vector<bool> is_merged(fresh_.num_landmarks(), false);
    for (uint32_t i = 0; i < known_.num_landmarks(); ++i) {
      const auto found = fresh_of_id.find(Value(known_.landmark_ids[i]));
      if (found == fresh_of_id.end()) {
        AppendLandmark(known_, i, &merged_);
        continue;
      }
      is_merged[found->second] = true;
      new_idx_of_fresh_[found->second] = i;
      AppendMerged(i, found->second);
    }
    for (uint32_t j = 0; j < fresh_.num_landmarks(); ++j) {
      if (is_merged[j]) {
        continue;
      }
      new_idx_of_fresh_[j] = static_cast<uint32_t>(merged_.num_landmarks());
      AppendLandmark(fresh_, j, &merged_);
    }
    AppendKeyframes();
    return std::move(merged_);
  }

 private:
  void AppendMerged(uint32_t known_idx, uint32_t fresh_idx) {
    const double known_sigma_m = SigmaFromCode(known_.sigma_codes[known_idx]);
    const double fresh_sigma_m = SigmaFromCode(fresh_.sigma_codes[fresh_idx]);
    const double known_information = 1.0 / (known_sigma_m * known_sigma_m);
    const double fresh_information = 1.0 / (fresh_sigma_m * fresh_sigma_m);
    const double information = known_information + fresh_information;
    const Eigen::Vector3d x_in_tile =
        (known_information * known_.x_in_tile[known_idx].cast<double>() +
         fresh_information * fresh_.x_in_tile[fresh_idx].cast<double>()) /
        information;
    merged_.landmark_ids.push_back(known_.landmark_ids[known_idx]);
    merged_.x_in_tile.push_back(QuantizePosition(x_in_tile));
    merged_.sigma_codes.push_back(
        SigmaCode(std::max(options_.least_sigma_m, 1.0 / std::sqrt(information))));

    const std::span<const HistoryEntry> before = known_.HistoryOf(known_idx);
    std::vector<HistoryEntry> history(before.begin(), before.end());
    for (const HistoryEntry& entry : fresh_.HistoryOf(fresh_idx)) {
      AppendToHistory(entry, &history);
    }
    merged_.history.insert(merged_.history.end(), history.begin(), history.end());
    merged_.history_begin.push_back(static_cast<uint32_t>(merged_.history.size()));

    std::vector<WeightedDescriptor> weighted;
    AppendDescriptorsOf(known_, known_idx, options_.old_weight_share, &weighted);
    AppendDescriptorsOf(fresh_, fresh_idx, 1.0, &weighted);
    Reduce(&weighted);
    for (const WeightedDescriptor& one : weighted) {
      AppendDescriptor(one);
    }
    merged_.descriptor_begin.push_back(static_cast<uint32_t>(merged_.num_descriptors()));
  }

  void AppendDescriptorsOf(const Tile& tile, uint32_t landmark_idx, double weight_share,
                           std::vector<WeightedDescriptor>* weighted) const {
    const uint32_t begin = tile.descriptor_begin[landmark_idx];
    const uint32_t end = tile.descriptor_begin[landmark_idx + 1];
    const uint8_t* codes = tile.codes.data() + size_t{begin} * tile.code_size;
    const DescriptorMatrix descriptors = codec_.Decode(codes, static_cast<int>(end - begin));
    for (uint32_t d = begin; d < end; ++d) {
      WeightedDescriptor one;
      one.descriptor = descriptors.row(d - begin);
      const uint8_t* code = codes + size_t{d - begin} * tile.code_size;
      one.code.assign(code, code + tile.code_size);
      one.weight = weight_share * WeightFromCode(tile.weight_codes[d]);
      if (tile.orientation_codes[d] != kNoOrientation) {
        one.orientation_rad = OrientationFromCode(tile.orientation_codes[d]);
      }
      if (const double size_m = SizeFromCode(tile.size_codes[d]); size_m > 0.0) {
        one.log_size = std::log(size_m);
      }
      one.azimuth_rad = AzimuthFromCode(tile.azimuth_codes[d]);
      weighted->push_back(std::move(one));
    }
  }

  // Averages descriptors that are alike, nearest first, then keeps the heaviest.
  void Reduce(std::vector<WeightedDescriptor>* weighted) const {
    NearestPairs(weighted).AverageWithin(max_same_sq_distance_);
    double weight = 0.0;
    for (const WeightedDescriptor& one : *weighted) {
      weight += one.weight;
    }
    const int num_observations = std::max(1, static_cast<int>(std::lround(weight)));
    const auto wanted = static_cast<size_t>(std::max(1, summarizer_.NumModes(num_observations)));
    if (weighted->size() > wanted) {
      std::stable_sort(weighted->begin(), weighted->end(),
                       [](const WeightedDescriptor& x, const WeightedDescriptor& y) {
                         return x.weight > y.weight;
                       });
      weighted->resize(wanted);
    }
  }

  void AppendDescriptor(const WeightedDescriptor& one) {
    std::vector<uint8_t> code = one.code;
    if (code.empty()) {
      const DescriptorMatrix row = one.descriptor;
      code = codec_.Encode(row);
    }
    merged_.codes.insert(merged_.codes.end(), code.begin(), code.end());
    merged_.orientation_codes.push_back(one.orientation_rad ? OrientationCode(*one.orientation_rad)
                                                            : kNoOrientation);
    merged_.size_codes.push_back(SizeCode(one.log_size ? std::exp(*one.log_size) : 0.0));
    merged_.azimuth_codes.push_back(AzimuthCode(one.azimuth_rad));
    merged_.weight_codes.push_back(WeightCode(one.weight));
  }

  void AppendKeyframes() {
    merged_.keyframes = known_.keyframes;
    merged_.keyframe_begin = known_.keyframe_begin;
    merged_.keyframe_landmarks = known_.keyframe_landmarks;
    for (size_t k = 0; k < fresh_.num_keyframes(); ++k) {
      const auto begin = static_cast<std::ptrdiff_t>(merged_.keyframe_landmarks.size());
      for (const uint32_t landmark_idx : fresh_.LandmarksOfKeyframe(k)) {
        merged_.keyframe_landmarks.push_back(new_idx_of_fresh_[landmark_idx]);
      }
      std::sort(merged_.keyframe_landmarks.begin() + begin, merged_.keyframe_landmarks.end());
      merged_.keyframes.push_back(fresh_.keyframes[k]);
      merged_.keyframe_begin.push_back(static_cast<uint32_t>(merged_.keyframe_landmarks.size()));
    }
  }

  const Tile& known_;
  const Tile& fresh_;
  const DescriptorCodec& codec_;
  const AppearanceSummarizer& summarizer_;
  const MergeOptions& options_;
  float max_same_sq_distance_ = 0.0f;
  std::vector<uint32_t> new_idx_of_fresh_;
  Tile merged_;
};

}  // namespace

void MergeOptions::Validate() const { CheckOptions("ingest.upkeep.merging", *this); }

Tile MergeTiles(const Tile& known, const Tile& fresh, const DescriptorCodec& codec,
                const AppearanceSummarizer& summarizer, const MergeOptions& options) {
  return TileMerger(known, fresh, codec, summarizer, options).Merge();
}

}  // namespace cairn
