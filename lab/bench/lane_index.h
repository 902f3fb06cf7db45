// The landmarks that a vehicle sees from its lane.
#ifndef CAIRN_LAB_BENCH_LANE_INDEX_H_
#define CAIRN_LAB_BENCH_LANE_INDEX_H_

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <random>
#include <utility>
#include <vector>

#include "lab/bench/bench_streets.h"

namespace cairn {

// The landmarks of a tile by lane, sorted along the lane. A vehicle sees a contiguous range.
class LaneIndex {
 public:
  explicit LaneIndex(const std::vector<BenchLandmark>& landmarks) {
    for (uint32_t i = 0; i < landmarks.size(); ++i) {
      OfLane(landmarks[i].lane).push_back({landmarks[i].along_m, i});
    }
    for (auto& [lane, entries] : lanes_) {
      std::sort(entries.begin(), entries.end());
    }
  }

  // Returns ascending indices of at most `max_count` random landmarks that a vehicle at `along_m`
  // sees.
  std::vector<uint32_t> Sample(const BenchLane& lane, double along_m, int max_count,
                               std::mt19937_64* generator) {
    std::vector<Entry>& entries = OfLane(lane);
    const double near_m = along_m + lane.travel_sign * kBenchMinViewM;
    const double far_m = along_m + lane.travel_sign * kBenchMaxViewM;
    const auto first =
        std::lower_bound(entries.begin(), entries.end(), Entry{std::min(near_m, far_m), 0});
    const auto last =
        std::upper_bound(first, entries.end(), Entry{std::max(near_m, far_m), UINT32_MAX});
    std::vector<Entry> sampled;
    std::sample(first, last, std::back_inserter(sampled), max_count, *generator);
    std::vector<uint32_t> indices;
    for (const Entry& entry : sampled) {
      indices.push_back(entry.second);
    }
    std::sort(indices.begin(), indices.end());
    return indices;
  }

 private:
  using Entry = std::pair<double, uint32_t>;  // Coordinate along the street, landmark.

  std::vector<Entry>& OfLane(const BenchLane& lane) {
    for (auto& [known, entries] : lanes_) {
      if (known == lane) {
        return entries;
      }
    }
    return lanes_.emplace_back(lane, std::vector<Entry>()).second;
  }

  std::vector<std::pair<BenchLane, std::vector<Entry>>> lanes_;  // About a dozen.
};

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_LANE_INDEX_H_
