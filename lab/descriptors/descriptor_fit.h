// Fits the descriptor model to real SIFT by making it look at what was really seen.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_

#include <functional>
#include <string>
#include <vector>

#include "lab/descriptors/descriptor_model.h"
#include "lab/descriptors/real_looks.h"

namespace cairn {

// A place that was seen often, in one appearance mode.
struct DescriptorFitStreet {
  std::string name;
  RealLooks looks;
  // Flat textures that stay sharp do not change with distance, and more of them repeats than is
  // real: only viewing angles count.
  bool is_rendered = false;
};

struct DescriptorFitData {
  std::vector<DescriptorFitStreet> streets;  // At least one.
  RealLooks facade;                          // In several modes; may be empty.
  RealLooks repeats;                         // May be empty.
  DescriptorMatrix crowd;                    // RootSIFT of many things; may be empty.
};

// Named differences of logarithms between model and data; the fit makes their squares small.
struct DescriptorResidual {
  std::string name;
  double value = 0.0;
  double weight = 1.0;
};

// How well a model fits: the same statistics of real descriptors and of the model's for the same
// looks.
std::vector<DescriptorResidual> WithinResiduals(const DescriptorFitData& data,
                                                const DescriptorModelOptions& options);
std::vector<DescriptorResidual> BetweenResiduals(const DescriptorFitData& data,
                                                 const DescriptorModelOptions& options);

// Fits all but the seed, beginning at `start`: principal axes by fixed-point steps; the length of
// modes by what the facade's photos add; all else together by least squares over the medians of
// squared distances in cells of view difference and over quantiles of nearest-neighbour distances.
// Takes minutes; deterministic. `progress` (may be empty) is told what is done.
DescriptorModelOptions FitDescriptorModel(const DescriptorFitData& data,
                                          const DescriptorModelOptions& start,
                                          const std::function<void(const std::string&)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_
