#include "lab/rivals/kd_tree.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace cairn {
namespace {

// Grows the tree from the root. Nodes are numbered in the order of their splits.
class Builder {
 public:
  Builder(const ByteDescriptors& descriptors, size_t max_leaf_size)
      : rows_(descriptors.rows()),
        stride_(descriptors.scale().stride()),
        max_leaf_size_(max_leaf_size),
        order_(descriptors.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
  }

  struct Range {
    size_t begin = 0;
    size_t end = 0;
    size_t size() const { return end - begin; }
  };

  Range All() const { return {0, order_.size()}; }
  bool IsLeaf(const Range& range) const { return range.size() <= max_leaf_size_; }
  std::span<const uint32_t> Descriptors(const Range& range) const {
    return {order_.data() + range.begin, range.size()};
  }

  // Appends the bounding box of a range, `stride` bytes to each vector.
  void AppendBox(const Range& range, std::vector<uint8_t>* lows,
                 std::vector<uint8_t>* highs) const {
    lows->resize(lows->size() + stride_, range.size() > 0 ? 255 : 0);
    highs->resize(highs->size() + stride_, 0);
    uint8_t* low = lows->data() + lows->size() - stride_;
    uint8_t* high = highs->data() + highs->size() - stride_;
    for (const uint32_t descriptor : Descriptors(range)) {
      const uint8_t* row = rows_ + descriptor * stride_;
      for (size_t dim = 0; dim < stride_; ++dim) {
        low[dim] = std::min(low[dim], row[dim]);
        high[dim] = std::max(high[dim], row[dim]);
      }
    }
  }

  // Splits a range of at least two descriptors in half.
  std::pair<Range, Range> Split(const Range& range) {
    const size_t dim = WidestDim(range);
    const size_t middle = range.begin + range.size() / 2;
    std::nth_element(
        order_.begin() + static_cast<ptrdiff_t>(range.begin),
        order_.begin() + static_cast<ptrdiff_t>(middle),
        order_.begin() + static_cast<ptrdiff_t>(range.end), [&](uint32_t a, uint32_t b) {
          return std::pair(rows_[a * stride_ + dim], a) < std::pair(rows_[b * stride_ + dim], b);
        });
    return {{range.begin, middle}, {middle, range.end}};
  }

 private:
  // Returns the dimension with the largest variance.
  size_t WidestDim(const Range& range) const {
    std::vector<int64_t> sums(stride_, 0), sq_sums(stride_, 0);
    for (const uint32_t descriptor : Descriptors(range)) {
      const uint8_t* row = rows_ + descriptor * stride_;
      for (size_t dim = 0; dim < stride_; ++dim) {
        sums[dim] += row[dim];
        sq_sums[dim] += row[dim] * row[dim];
      }
    }
    const auto variance = [&](size_t dim) {
      return sq_sums[dim] * static_cast<int64_t>(range.size()) - sums[dim] * sums[dim];
    };
    size_t widest = 0;
    for (size_t dim = 1; dim < stride_; ++dim) {
      widest = variance(dim) > variance(widest) ? dim : widest;
    }
    return widest;
  }

  const uint8_t* rows_;
  size_t stride_;
  size_t max_leaf_size_;
  std::vector<uint32_t> order_;
};

}  // namespace

KdTree::BuiltTree KdTree::Build(const ByteDescriptors& descriptors, const KdTreeOptions& options) {
  Builder builder(descriptors, options.max_leaf_size);
  std::vector<uint32_t> cells(descriptors.size());
  Tree tree;
  std::vector<Builder::Range> ranges = {builder.All()};
  for (size_t node = 0; node < ranges.size(); ++node) {
    const Builder::Range range = ranges[node];
    builder.AppendBox(range, &tree.lows, &tree.highs);
    if (builder.IsLeaf(range)) {
      tree.links.push_back(kLeafBit | static_cast<uint32_t>(tree.num_leaves));
      for (const uint32_t descriptor : builder.Descriptors(range)) {
        cells[descriptor] = static_cast<uint32_t>(tree.num_leaves);
      }
      ++tree.num_leaves;
    } else {
      tree.links.push_back(static_cast<uint32_t>(ranges.size()));
      const auto [lower, upper] = builder.Split(range);
      ranges.push_back(lower);
      ranges.push_back(upper);
    }
  }
  return {std::move(tree), std::move(cells)};
}

KdTree::KdTree(const Codebook& codebook, std::span<const uint8_t> codes,
               const KdTreeOptions& options)
    : KdTree(ByteDescriptors(codebook, codes), options) {}

KdTree::KdTree(const ByteDescriptors& descriptors, const KdTreeOptions& options)
    : KdTree(descriptors, Build(descriptors, options), options) {}

KdTree::KdTree(const ByteDescriptors& descriptors, BuiltTree built, const KdTreeOptions& options)
    : num_probes_(options.num_probes),
      tree_(std::move(built.tree)),
      lists_(descriptors, built.cells, tree_.num_leaves) {}

int32_t KdTree::SqDistanceToBox(const int16_t* query_steps, uint32_t node) const {
  const int stride = lists_.scale().stride();
  const uint8_t* low = tree_.lows.data() + size_t{node} * stride;
  const uint8_t* high = tree_.highs.data() + size_t{node} * stride;
  int32_t sum = 0;
  for (int dim = 0; dim < stride; ++dim) {
    const int32_t outside =
        std::max({low[dim] - query_steps[dim], query_steps[dim] - high[dim], 0});
    sum += outside * outside;
  }
  return sum;
}

void KdTree::AppendVisits(const int16_t* query_steps, uint32_t query_idx, int32_t max_sq_steps,
                          std::vector<CellVisit>* visits) const {
  using Entry = std::pair<int32_t, uint32_t>;  // Squared distance to the box, node.
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> nodes;
  nodes.push({0, 0});
  size_t num_visits = 0;
  while (!nodes.empty() && num_visits < num_probes_) {
    const uint32_t link = tree_.links[nodes.top().second];
    nodes.pop();
    if ((link & kLeafBit) != 0) {
      visits->push_back({link & ~kLeafBit, query_idx});
      ++num_visits;
      continue;
    }
    for (const uint32_t child : {link, link + 1}) {
      const int32_t sq_steps = SqDistanceToBox(query_steps, child);
      if (sq_steps <= max_sq_steps) {
        nodes.push({sq_steps, child});
      }
    }
  }
}

int64_t KdTree::Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const {
  HitCollector collector(lists_.scale(), request);
  const std::vector<int16_t> query_steps = lists_.scale().QuantizeQueries(request.queries);
  const BlockQueries queries = lists_.Prepare(query_steps);
  std::vector<CellVisit> visits;
  int64_t num_distances = 0;
  for (uint32_t query = 0; query < request.queries.rows() && !collector.ShouldStop(); ++query) {
    visits.clear();
    AppendVisits(query_steps.data() + size_t{query} * lists_.scale().stride(), query,
                 collector.max_sq_steps(query), &visits);
    num_distances += lists_.Search(queries, visits, &collector);
  }
  collector.MoveTo(hits);
  return num_distances;
}

size_t KdTree::MemoryBytes() const {
  return tree_.links.capacity() * sizeof(uint32_t) + tree_.lows.capacity() +
         tree_.highs.capacity() + lists_.MemoryBytes();
}

}  // namespace cairn
