#include "lab/rivals/index_methods.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "core/check.h"
#include "core/require.h"
#include "lab/rivals/inverted_multi_index.h"
#include "lab/rivals/kd_tree.h"

namespace cairn {
namespace {

class MultiIndexFactory : public IndexFactory {
 public:
  explicit MultiIndexFactory(const InvertedMultiIndexOptions& options) : options_(options) {}

  std::string name() const override {
    return fmt::format("inverted_multi_index {} {} {} {}", options_.num_words, options_.num_probes,
                       options_.num_iterations, options_.seed);
  }
  std::unique_ptr<const MatchingIndex> Make(const Codebook& codebook,
                                            std::span<const uint8_t> codes) const override {
    return std::make_unique<InvertedMultiIndex>(codebook, codes, options_);
  }

 private:
  InvertedMultiIndexOptions options_;
};

class KdTreeFactory : public IndexFactory {
 public:
  explicit KdTreeFactory(const KdTreeOptions& options) : options_(options) {}

  std::string name() const override {
    return fmt::format("kd_tree {} {}", options_.max_leaf_size, options_.num_probes);
  }
  std::unique_ptr<const MatchingIndex> Make(const Codebook& codebook,
                                            std::span<const uint8_t> codes) const override {
    return std::make_unique<KdTree>(codebook, codes, options_);
  }

 private:
  KdTreeOptions options_;
};

}  // namespace

void InvertedMultiIndexOptions::Validate() const {
  RequireWithin("multi_index.num_words", num_words, 1, 4'096);
  RequireWithin("multi_index.num_probes", num_probes, 1, 1'000'000);
  RequireWithin("multi_index.num_iterations", num_iterations, 0, 100);
}

void KdTreeOptions::Validate() const {
  RequireWithin("kd_tree.max_leaf_size", max_leaf_size, 1, 100'000);
  RequireWithin("kd_tree.num_probes", num_probes, 1, 1'000'000);
}

const char* IndexMethodName(IndexMethod method) {
  switch (method) {
    case IndexMethod::kRandomGrids:
      return "random_grids";
    case IndexMethod::kInvertedLists:
      return "inverted_lists";
    case IndexMethod::kInvertedMultiIndex:
      return "inverted_multi_index";
    case IndexMethod::kKdTree:
      return "kd_tree";
    case IndexMethod::kExhaustive:
      return "exhaustive";
  }
  CAIRN_CHECK(false, "an IndexMethod has a name");
  return "";
}

IndexOptions MakeIndexOptions(IndexMethod method, const IndexMethodOptions& options) {
  IndexOptions index;
  index.grids = options.grids;
  index.lists = options.lists;
  switch (method) {
    case IndexMethod::kRandomGrids:
      index.kind = IndexKind::kRandomGrids;
      break;
    case IndexMethod::kInvertedLists:
      index.kind = IndexKind::kInvertedLists;
      break;
    case IndexMethod::kExhaustive:
      index.kind = IndexKind::kExhaustive;
      break;
    case IndexMethod::kInvertedMultiIndex:
      options.multi_index.Validate();
      index.kind = IndexKind::kOther;
      index.other = std::make_shared<MultiIndexFactory>(options.multi_index);
      break;
    case IndexMethod::kKdTree:
      options.kd_tree.Validate();
      index.kind = IndexKind::kOther;
      index.other = std::make_shared<KdTreeFactory>(options.kd_tree);
      break;
  }
  index.Validate();
  return index;
}

}  // namespace cairn
