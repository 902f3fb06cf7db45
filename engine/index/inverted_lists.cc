#include "engine/index/inverted_lists.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cairn {
namespace {

TileLists MakeLists(const ByteDescriptors& descriptors, const InvertedListsOptions& options) {
  const ByteWords words(descriptors, {.first_dim = 0,
                                      .num_dims = descriptors.scale().dim(),
                                      .num_words = options.num_lists,
                                      .num_iterations = options.num_iterations,
                                      .seed = options.seed});
  TileLists lists = ListsOfCells(words.NearestWords(descriptors), words.size());
  // Two equal offsets enclose an empty list.
  lists.begin.erase(std::unique(lists.begin.begin(), lists.begin.end()), lists.begin.end());
  return lists;
}

}  // namespace

TileLists MakeTileLists(const Codebook& codebook, std::span<const uint8_t> codes,
                        const InvertedListsOptions& options) {
  return codes.empty() ? TileLists() : MakeLists(ByteDescriptors(codebook, codes), options);
}

struct InvertedLists::ExpandedLists {
  ExpandedLists(const CodeWords& words, std::span<const uint8_t> codes,
                std::span<const uint32_t> begin)
      : rows(words, codes, begin, &sums) {}

  std::vector<uint32_t> sums;  // Sums of the rows of each list.
  BlockedRows rows;
};

InvertedLists::InvertedLists(const Codebook& codebook, std::span<const uint8_t> codes,
                             const InvertedListsOptions& options, TileLists lists)
    : InvertedLists(ByteScale(codebook),
                    ExpandedLists(CodeWords(codebook, ByteScale(codebook)), codes, lists.begin),
                    options.num_probes, std::move(lists)) {}

InvertedLists::InvertedLists(const ByteScale& scale, ExpandedLists&& expanded, size_t num_probes,
                             TileLists&& lists)
    : num_probes_(std::min(num_probes, lists.num_lists())),
      lists_(scale, std::move(expanded.rows), std::move(lists)),
      words_(expanded.sums, lists_.lists().begin, scale.dim()) {}

std::vector<CellVisit> InvertedLists::MakeVisits(const std::vector<int16_t>& query_steps,
                                                 size_t num_queries) const {
  const BlockQueries queries = words_.Prepare(query_steps, lists_.scale().stride());
  NearestScratch scratch;
  std::vector<BlockHit> probed;  // num_probes_ per query.
  probed.reserve(num_queries * num_probes_);
  std::vector<uint32_t> begin(words_.size() + 1, 0);
  for (size_t query = 0; query < num_queries; ++query) {
    words_.NearestWords(queries[query], num_probes_, &scratch, &probed);
  }
  for (const BlockHit& word : probed) {
    ++begin[word.row + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<CellVisit> visits(probed.size());
  for (size_t i = 0; i < probed.size(); ++i) {
    visits[begin[probed[i].row]++] = {probed[i].row, static_cast<uint32_t>(i / num_probes_)};
  }
  return visits;
}

int64_t InvertedLists::Search(const SearchRequest& request,
                              std::vector<DescriptorHit>* hits) const {
  HitCollector collector(lists_.scale(), request);
  if (num_probes_ == 0) {
    return 0;
  }
  const std::vector<int16_t> query_steps = lists_.scale().QuantizeQueries(request.queries);
  const std::vector<CellVisit> visits = MakeVisits(query_steps, request.queries.rows());
  const int64_t num_distances = lists_.Search(lists_.Prepare(query_steps), visits, &collector);
  collector.MoveTo(hits);
  return num_distances;
}

}  // namespace cairn
