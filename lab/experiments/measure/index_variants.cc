#include "lab/experiments/measure/index_variants.h"

namespace cairn {
namespace {

constexpr int kQuickWords = 64;

}  // namespace

const char* IndexLabel(IndexMethod method) {
  switch (method) {
    case IndexMethod::kRandomGrids:
      return "random grids";
    case IndexMethod::kInvertedLists:
      return "inverted lists";
    case IndexMethod::kInvertedMultiIndex:
      return "inverted multi-index";
    case IndexMethod::kKdTree:
      return "kd-tree";
    case IndexMethod::kExhaustive:
      return "exhaustive";
  }
  return "exhaustive";
}

IndexMethodOptions DefaultsAt(ExperimentSize size) {
  IndexMethodOptions options;
  if (size == ExperimentSize::kQuick) {
    options.multi_index.num_words = kQuickWords;
  }
  return options;
}

IndexOptions IndexOfMethod(IndexMethod method, ExperimentSize size) {
  return MakeIndexOptions(method, DefaultsAt(size));
}

IndexOptions IndexWithEffort(IndexMethod method, ExperimentSize size, int effort) {
  IndexMethodOptions options = DefaultsAt(size);
  switch (method) {
    case IndexMethod::kRandomGrids:
      options.grids.num_probes = effort;
      break;
    case IndexMethod::kInvertedLists:
      options.lists.num_probes = effort;
      break;
    case IndexMethod::kInvertedMultiIndex:
      options.multi_index.num_probes = effort;
      break;
    case IndexMethod::kKdTree:
      options.kd_tree.num_probes = effort;
      break;
    case IndexMethod::kExhaustive:
      break;
  }
  return MakeIndexOptions(method, options);
}

std::vector<int> Efforts(IndexMethod method, ExperimentSize size) {
  const bool is_quick = size == ExperimentSize::kQuick;
  switch (method) {
    case IndexMethod::kRandomGrids:
      return is_quick ? std::vector<int>{4, 28} : std::vector<int>{4, 28, 100};
    case IndexMethod::kInvertedLists:
      return is_quick ? std::vector<int>{8} : std::vector<int>{8};
    case IndexMethod::kInvertedMultiIndex:
      return is_quick ? std::vector<int>{100, 1000} : std::vector<int>{100, 1000, 10'000};
    case IndexMethod::kKdTree:
      return is_quick ? std::vector<int>{64} : std::vector<int>{64};
    case IndexMethod::kExhaustive:
      return {1};
  }
  return {};
}

}  // namespace cairn
