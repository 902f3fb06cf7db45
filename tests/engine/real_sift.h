// Real SIFT descriptors in the same form as the synthetic ones.
#ifndef CAIRN_TESTS_ENGINE_REAL_SIFT_H_
#define CAIRN_TESTS_ENGINE_REAL_SIFT_H_

#include <filesystem>

#include "engine/synthetic_descriptors.h"

namespace cairn::testing {

// Reads vectors in the .u8bin format (number and dimension as int32, then bytes), normalizes them
// and projects them to their first 16 principal components. The last `num_queries` become queries;
// each other vector is a landmark with one descriptor. Same-landmark distances are the distances
// from the queries to their nearest neighbors.
SyntheticDescriptors RealSift(const std::filesystem::path& u8bin, int num_queries);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_REAL_SIFT_H_
