#include "eval/experiments/index_variants.h"

namespace cairn {
namespace {

constexpr int kQuickWords = 64;

}  // namespace

const char* IndexLabel(IndexKind kind) {
  switch (kind) {
    case IndexKind::kRandomGrids:
      return "random grids";
    case IndexKind::kInvertedLists:
      return "inverted lists";
    case IndexKind::kInvertedMultiIndex:
      return "inverted multi-index";
    case IndexKind::kKdTree:
      return "kd-tree";
    case IndexKind::kExhaustive:
      return "exhaustive";
  }
  return "exhaustive";
}

IndexOptions IndexOfKind(IndexKind kind, ExperimentSize size) {
  IndexOptions options;
  options.kind = kind;
  if (size == ExperimentSize::kQuick) {
    options.multi_index.num_words = kQuickWords;
  }
  return options;
}

IndexOptions IndexWithEffort(IndexKind kind, ExperimentSize size, int effort) {
  IndexOptions options = IndexOfKind(kind, size);
  switch (kind) {
    case IndexKind::kRandomGrids:
      options.grids.num_probes = effort;
      break;
    case IndexKind::kInvertedLists:
      options.lists.num_probes = effort;
      break;
    case IndexKind::kInvertedMultiIndex:
      options.multi_index.num_probes = effort;
      break;
    case IndexKind::kKdTree:
      options.kd_tree.num_probes = effort;
      break;
    case IndexKind::kExhaustive:
      break;
  }
  return options;
}

std::vector<int> Efforts(IndexKind kind, ExperimentSize size) {
  const bool is_quick = size == ExperimentSize::kQuick;
  switch (kind) {
    case IndexKind::kRandomGrids:
      return is_quick ? std::vector<int>{4, 28} : std::vector<int>{4, 28, 100};
    case IndexKind::kInvertedLists:
      return is_quick ? std::vector<int>{8} : std::vector<int>{8};
    case IndexKind::kInvertedMultiIndex:
      return is_quick ? std::vector<int>{100, 1000} : std::vector<int>{100, 1000, 10'000};
    case IndexKind::kKdTree:
      return is_quick ? std::vector<int>{64} : std::vector<int>{64};
    case IndexKind::kExhaustive:
      return {1};
  }
  return {};
}

}  // namespace cairn
