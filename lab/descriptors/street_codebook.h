// Trains a codebook on rendered streets: the codebook that comes with Cairn.
#ifndef CAIRN_LAB_DESCRIPTORS_STREET_CODEBOOK_H_
#define CAIRN_LAB_DESCRIPTORS_STREET_CODEBOOK_H_

#include <cstdint>
#include <functional>

#include "core/scene/reconstruction.h"
#include "storage/codebook/codebook.h"

namespace cairn {

struct StreetCodebookOptions {
  int num_streets = 3;      // Each has houses, paint and trees of its own.
  double length_m = 120.0;  // Of a street.
  uint64_t seed = 1;
  int num_threads = 2;  // The result does not depend on it.

  void Validate() const;  // Throws Error(kInvalidArgument) that names the field.
};

// Receives the streets done and the total.
using StreetCodebookProgress = std::function<void(int done, int total)>;

// Photographs streets, reconstructs them with their known poses, and trains on all of them
// together. Every other street has trees. Deterministic. Throws as TrainCodebook.
Codebook TrainStreetCodebook(const StreetCodebookOptions& options,
                             const StreetCodebookProgress& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_STREET_CODEBOOK_H_
