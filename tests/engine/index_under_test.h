// The kinds of index that the engine has, with settings for tests.
#ifndef CAIRN_TESTS_ENGINE_INDEX_UNDER_TEST_H_
#define CAIRN_TESTS_ENGINE_INDEX_UNDER_TEST_H_

#include <cstdint>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "engine/index/index_options.h"
#include "engine/index/matching_index.h"

namespace cairn::testing {

struct IndexUnderTest {
  std::string name;
  IndexOptions options;   // For tiles of some thousand descriptors.
  IndexOptions complete;  // Nothing is missed.

  friend void PrintTo(const IndexUnderTest& index, std::ostream* out) { *out << index.name; }
};

// An index of a kind that the engine does not know.
inline IndexOptions OtherIndex() {
  class Factory : public IndexFactory {
   public:
    std::string name() const override { return "exhaustive search of a test"; }
    std::unique_ptr<const MatchingIndex> Make(const Codebook& codebook,
                                              std::span<const uint8_t> codes) const override {
      IndexOptions options;
      options.kind = IndexKind::kExhaustive;
      return MakeMatchingIndex(codebook, codes, options);
    }
  };
  IndexOptions options;
  options.kind = IndexKind::kOther;
  options.other = std::make_shared<const Factory>();
  return options;
}

inline std::vector<IndexUnderTest> EngineIndices() {
  IndexUnderTest grids = {"random_grids", {}, {}};
  grids.complete.grids = {.num_grids = 1,
                          .num_hashed_dims = 1,
                          .cell_width_sigmas = 1000.0,
                          .num_probes = 2,
                          .max_candidates_per_cell = 10'000};
  IndexUnderTest two_grids = grids;
  two_grids.name = "two_random_grids";
  two_grids.options.grids.num_grids = two_grids.complete.grids.num_grids = 2;
  IndexUnderTest lists = {"inverted_lists", {}, {}};
  lists.options.kind = lists.complete.kind = IndexKind::kInvertedLists;
  lists.options.lists.num_lists = lists.complete.lists.num_lists = 64;
  lists.complete.lists.num_probes = 64;
  IndexUnderTest exhaustive = {"exhaustive", {}, {}};
  exhaustive.options.kind = exhaustive.complete.kind = IndexKind::kExhaustive;
  return {grids, two_grids, lists, exhaustive};
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_INDEX_UNDER_TEST_H_
