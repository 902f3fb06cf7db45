#include "lab/rivals/inverted_multi_index.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>
#include <utility>

namespace cairn {
namespace {

// Finds the `count` nearest words, nearest first; of equally near words, the first. count <=
// words.size().
void NearestFirst(const ByteWords& words, const BlockQuery& query, size_t count,
                  NearestScratch* scratch, std::vector<BlockHit>* nearest) {
  nearest->clear();
  words.NearestWords(query, count, scratch, nearest);
  std::sort(nearest->begin(), nearest->end(), [](const BlockHit& a, const BlockHit& b) {
    return std::tie(a.sq_distance, a.row) < std::tie(b.sq_distance, b.row);
  });
}

}  // namespace

// Visits pairs of ranks in ascending order of their summed distances. A pair enters the queue after
// the preceding pairs in its row and its column have left it.
class InvertedMultiIndex::MultiSequence {
 public:
  MultiSequence(const InvertedMultiIndex& index, const std::vector<int16_t>& query_steps)
      : index_(index),
        first_queries_(index.words_.first().Prepare(query_steps, index.lists_.scale().stride())),
        second_queries_(index.words_.second().Prepare(query_steps, index.lists_.scale().stride())) {
    // Of the p nearest pairs, few have a rank above a few times sqrt(p) in either half. The paper,
    // too, first takes the nearest words of each half. If there are not enough pairs, all words are
    // used.
    constexpr double kSpread = 4.0;
    const auto reach =
        static_cast<size_t>(std::ceil(kSpread * std::sqrt(static_cast<double>(num_probes()))));
    const size_t num_words = index.words_.first().size();
    reach_ = num_probes() >= num_words * num_words ? num_words : std::min(reach, num_words);
  }

  void AppendVisits(uint32_t query_idx, std::vector<CellVisit>* visits) {
    NearestFirst(index_.words_.first(), first_queries_[query_idx], reach_, &scratch_, &first_);
    NearestFirst(index_.words_.second(), second_queries_[query_idx], reach_, &scratch_, &second_);
    num_taken_.assign(reach_, 0);
    queue_ = {};
    Push(0, 0);
    const size_t num_visits = std::min(num_probes(), reach_ * reach_);
    for (size_t i = 0; i < num_visits; ++i) {
      const auto [row, column] = queue_.top().second;
      queue_.pop();
      num_taken_[row] = column + 1;
      visits->push_back({static_cast<uint32_t>(first_[row].row * index_.words_.second().size() +
                                               second_[column].row),
                         query_idx});
      if (column + 1 < reach_ && (row == 0 || num_taken_[row - 1] > column + 1)) {
        Push(row, column + 1);
      }
      if (row + 1 < reach_ && num_taken_[row + 1] == column) {
        Push(row + 1, column);
      }
    }
  }

 private:
  using RankPair = std::pair<uint32_t, uint32_t>;
  using Entry = std::pair<int32_t, RankPair>;

  size_t num_probes() const { return index_.num_probes_; }
  void Push(uint32_t row, uint32_t column) {
    queue_.push({first_[row].sq_distance + second_[column].sq_distance, {row, column}});
  }

  const InvertedMultiIndex& index_;
  const BlockQueries first_queries_, second_queries_;
  size_t reach_;  // Words of each half to consider.
  NearestScratch scratch_;
  std::vector<BlockHit> first_, second_;
  std::vector<uint32_t> num_taken_;  // Number of pairs of each row that left the queue.
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

InvertedMultiIndex::InvertedMultiIndex(const Codebook& codebook, std::span<const uint8_t> codes,
                                       const InvertedMultiIndexOptions& options)
    : InvertedMultiIndex(ByteDescriptors(codebook, codes), options) {}

InvertedMultiIndex::InvertedMultiIndex(const ByteDescriptors& descriptors,
                                       const InvertedMultiIndexOptions& options)
    : num_probes_(options.num_probes),
      words_(descriptors, options.num_words, options.num_iterations, options.seed),
      lists_(descriptors, words_.NearestCells(descriptors), words_.num_cells()) {}

int64_t InvertedMultiIndex::Search(const SearchRequest& request,
                                   std::vector<DescriptorHit>* hits) const {
  HitCollector collector(lists_.scale(), request);
  if (lists_.size() == 0) {
    return 0;
  }
  const std::vector<int16_t> query_steps = lists_.scale().QuantizeQueries(request.queries);
  const BlockQueries queries = lists_.Prepare(query_steps);
  MultiSequence sequence(*this, query_steps);
  std::vector<CellVisit> visits;
  int64_t num_distances = 0;
  constexpr uint32_t kQueriesPerBlock = 16;
  const auto num_queries = static_cast<uint32_t>(request.queries.rows());
  for (uint32_t begin = 0; begin < num_queries && !collector.ShouldStop();
       begin += kQueriesPerBlock) {
    visits.clear();
    for (uint32_t query = begin; query < std::min(begin + kQueriesPerBlock, num_queries); ++query) {
      sequence.AppendVisits(query, &visits);
    }
    num_distances += lists_.Search(queries, visits, &collector);
  }
  collector.MoveTo(hits);
  return num_distances;
}

}  // namespace cairn
