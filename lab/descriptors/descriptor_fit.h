// Fits the descriptor model to real SIFT. The model simulates the looks of the real data, and the
// fit compares the statistics.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_

#include <functional>
#include <string>
#include <vector>

#include "lab/descriptors/descriptor_model.h"
#include "lab/descriptors/real_looks.h"

namespace cairn {

// A place with many looks, all in one appearance mode.
struct DescriptorFitStreet {
  std::string name;
  RealLooks looks;
  // For rendered streets, only viewing angles count. Their flat textures stay sharp and do not
  // change with distance, and more of them repeats than in reality.
  bool is_rendered = false;
};

struct DescriptorFitData {
  std::vector<DescriptorFitStreet> streets;  // At least one.
  RealLooks facade;                          // In several appearance modes; may be empty.
  RealLooks repeats;                         // May be empty.
  DescriptorMatrix crowd;                    // RootSIFT of many different things; may be empty.
};

// A named difference of logarithms between model and data. The fit minimizes the sum of their
// squares.
struct DescriptorResidual {
  std::string name;
  double value = 0.0;
  double weight = 1.0;
};

// Measures how well a model fits: compares the statistics of real descriptors with those of the
// model's descriptors for the same looks.
std::vector<DescriptorResidual> WithinResiduals(const DescriptorFitData& data,
                                                const DescriptorModelOptions& options);
std::vector<DescriptorResidual> BetweenResiduals(const DescriptorFitData& data,
                                                 const DescriptorModelOptions& options);

// Fits all options except the seed, starting at `start`:
// - the principal axes, by fixed-point steps;
// - the length of modes, from the difference that the facade's photos add;
// - all other options together, by least squares over the medians of squared distances in cells of
//   view difference and over quantiles of nearest-neighbor distances.
// Takes minutes. Deterministic. `progress` (may be empty) receives a description of each step.
DescriptorModelOptions FitDescriptorModel(const DescriptorFitData& data,
                                          const DescriptorModelOptions& start,
                                          const std::function<void(const std::string&)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_FIT_H_
