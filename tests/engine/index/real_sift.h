// Real SIFT descriptors in the same form as the synthetic ones.
#ifndef CAIRN_TESTS_ENGINE_INDEX_REAL_SIFT_H_
#define CAIRN_TESTS_ENGINE_INDEX_REAL_SIFT_H_

#include <filesystem>

#include "engine/index/synthetic_descriptors.h"

namespace cairn::testing {

// Reads vectors in the .u8bin format (number and dimension as int32, then bytes), normalises and
// projects them to their 16 first principal components. The last `num_queries` become queries, each
// other is a landmark with one descriptor. The same-landmark distances are those from the queries
// to their nearest neighbour.
SyntheticDescriptors RealSift(const std::filesystem::path& u8bin, int num_queries);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_INDEX_REAL_SIFT_H_
