#include "engine/index/random_grids.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "core/random.h"
#include "engine/index/shared_visits.h"

namespace cairn {
namespace {

// With enough buckets, collisions of cells cost little; with few enough, the buckets' bounds fit a
// level 2 cache.
int NumBucketBits(size_t num_descriptors) {
  constexpr int kBitsLess = 3;
  return std::clamp(static_cast<int>(std::bit_width(num_descriptors)) - kBitsLess, 1, 26);
}

// Sorts visits, which are in order of query, by cell, and removes repetitions, since cells in one
// bucket are searched together. A counting sort.
std::vector<CellVisit> SortedByCell(const std::vector<CellVisit>& visits, size_t num_cells) {
  std::vector<uint32_t> next(num_cells + 1, 0);
  for (const CellVisit& visit : visits) {
    ++next[visit.cell + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<CellVisit> sorted(visits.size());
  for (const CellVisit& visit : visits) {
    sorted[next[visit.cell]++] = visit;
  }
  const auto end =
      std::unique(sorted.begin(), sorted.end(), [](const CellVisit& a, const CellVisit& b) {
        return a.cell == b.cell && a.query_idx == b.query_idx;
      });
  sorted.erase(end, sorted.end());
  return sorted;
}

// Replaces each index by the number at that index.
void ReplaceEach(std::span<const uint32_t> numbers, LargeVector<uint32_t>* indices) {
  for (uint32_t& index : *indices) {
    index = numbers[index];
  }
}

// Removes hits that an earlier grid has found, too, from the hits starting at `begin`, which are
// ordered by query.
void RemoveRepeated(size_t begin, size_t num_descriptors, std::vector<DescriptorHit>* hits) {
  std::vector<bool> was_found(num_descriptors);
  size_t num_kept = begin;
  for (size_t first = begin, end = begin; first < hits->size(); first = end) {
    const size_t first_kept = num_kept;
    for (; end < hits->size() && (*hits)[end].query_idx == (*hits)[first].query_idx; ++end) {
      const DescriptorHit hit = (*hits)[end];
      (*hits)[num_kept] = hit;
      num_kept += was_found[hit.descriptor_idx] ? 0 : 1;
      was_found[hit.descriptor_idx] = true;
    }
    for (size_t i = first_kept; i < num_kept; ++i) {
      was_found[(*hits)[i].descriptor_idx] = false;
    }
  }
  hits->resize(num_kept);
}

}  // namespace

RandomGrids::RandomGrids(const Codebook& codebook, std::span<const uint8_t> codes,
                         const RandomGridsOptions& options, BuildExtent extent,
                         std::span<const uint32_t> descriptors)
    : codebook_(&codebook),
      codes_(codes),
      words_(codebook, ByteScale(codebook)),
      options_(options),
      hasher_(codebook, options),
      num_bucket_bits_(NumBucketBits(codes.size() / codebook.num_subspaces)),
      grids_(options.num_grids) {
  AddGrid(descriptors);
  while (extent == BuildExtent::kWhole && !RandomGrids::is_complete()) {
    AddGrid({});
  }
}

void RandomGrids::BuildPart() const {
  const std::lock_guard lock(mutex_);
  if (!is_complete()) {
    AddGrid({});
  }
}

void RandomGrids::AddGrid(std::span<const uint32_t> descriptors) const {
  const int grid = num_built();
  grids_[grid].emplace(MakeGrid(grid, descriptors));
  num_built_.store(grid + 1, std::memory_order_release);
  if (is_complete()) {
    places_ = {};
  }
}

CellLists RandomGrids::MakeGrid(int grid, std::span<const uint32_t> descriptors) const {
  TileLists cells =
      SortIntoBuckets(hasher_.HashCodes(*codebook_, codes_, grid), num_bucket_bits_,
                      options_.max_candidates_per_cell, RandomBits(options_.seed, grid));
  BlockedRows rows(words_, codes_, cells.members);
  CellListsOptions options;
  options.max_compared = static_cast<uint32_t>(options_.max_candidates_per_cell);
  if (grid > 0) {
    ReplaceEach(places_, &cells.members);
    options.order = order();
    return CellLists(ByteScale(*codebook_), std::move(rows), std::move(cells), options);
  }
  if (hasher_.num_grids() > 1) {
    places_.resize(cells.members.size());
    for (uint32_t place = 0; place < cells.members.size(); ++place) {
      places_[cells.members[place]] = place;
    }
  }
  if (!descriptors.empty()) {
    ReplaceEach(descriptors, &cells.members);
  }
  return CellLists(ByteScale(*codebook_), std::move(rows), std::move(cells), options);
}

std::vector<CellVisit> RandomGrids::MakeVisits(const DescriptorMatrix& queries, int grid) const {
  std::vector<uint32_t> hashes(hasher_.num_probes());
  std::vector<CellVisit> visits;
  visits.reserve(queries.rows() * hashes.size());
  for (Eigen::Index query = 0; query < queries.rows(); ++query) {
    hasher_.FindProbes(queries.row(query).data(), grid, hashes.data());
    for (const uint32_t hash : hashes) {
      visits.push_back({BucketOf(hash, num_bucket_bits_), static_cast<uint32_t>(query)});
    }
  }
  return SortedByCell(visits, grids_[grid]->num_cells());
}

int64_t RandomGrids::Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const {
  const CellLists& first = *grids_.front();
  HitCollector collector(first.scale(), request);
  const std::vector<int16_t> query_steps = first.scale().QuantizeQueries(request.queries);
  const BlockQueries queries = first.Prepare(query_steps);
  int64_t num_distances = 0;
  const int num_grids = num_built();
  SharedVisits own_visits;
  SharedVisits& visits = request.shared_visits != nullptr ? *request.shared_visits : own_visits;
  for (int grid = 0; grid < num_grids; ++grid) {
    const std::vector<CellVisit>& to_grid =
        visits.OfGrid(grid, num_bucket_bits_, [&] { return MakeVisits(request.queries, grid); });
    num_distances += grids_[grid]->Search(queries, to_grid, &collector);
  }
  if (request.receiver == nullptr) {
    const size_t begin = hits->size();
    collector.MoveTo(hits);
    if (num_grids > 1) {
      RemoveRepeated(begin, first.size(), hits);
    }
  }
  return num_distances;
}

size_t RandomGrids::MemoryBytes() const {
  // All grids have the same size, and the first is always built.
  return hasher_.MemoryBytes() + grids_.size() * grids_.front()->MemoryBytes();
}

}  // namespace cairn
