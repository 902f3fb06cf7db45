#include "engine/matching/random_grids.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/matching/cell_sketch.h"
#include "engine/matching/distance_kernels.h"
#include "engine/matching/random_bits.h"

namespace cairn {
namespace {

// Queries whose buckets are located together, so that the memory they lie in arrives in parallel.
constexpr size_t kQueriesPerBlock = 16;
constexpr size_t kCacheLineBytes = 64;

int NumBucketBits(size_t num_descriptors) {
  return std::clamp(static_cast<int>(std::bit_width(num_descriptors)) - 1, 1, 26);
}

// A set of descriptors that is cleared in time linear in its members.
class DescriptorSet {
 public:
  explicit DescriptorSet(size_t num_descriptors) : words_((num_descriptors + 63) / 64) {}

  // Returns true if the descriptor was not yet in the set.
  bool Insert(uint32_t descriptor) {
    uint64_t& word = words_[descriptor / 64];
    const uint64_t bit = uint64_t{1} << (descriptor % 64);
    const bool is_new = (word & bit) == 0;
    word |= bit;
    return is_new;
  }
  void Erase(std::span<const uint32_t> descriptors) {
    for (const uint32_t descriptor : descriptors) {
      words_[descriptor / 64] = 0;
    }
  }

 private:
  std::vector<uint64_t> words_;
};

}  // namespace

// Works through blocks of queries in three steps, each of which asks for the memory that the next
// one reads: bounds of buckets, their content, the descriptors' rows.
class RandomGrids::Searcher {
 public:
  Searcher(const RandomGrids& grids, const DescriptorMatrix& queries)
      : grids_(grids),
        queries_(queries),
        steps_(grids.descriptors_.scale().QuantizeQueries(queries)),
        num_grids_(grids.num_standing()),
        probes_per_query_(size_t{1} * num_grids_ * grids.hasher_.num_probes()),
        sq_units_per_sq_step_(
            grids.hasher_.SqUnitsOf(std::pow(grids.descriptors_.scale().step(), 2))),
        coordinates_(kQueriesPerBlock * grids.hasher_.num_coordinates()),
        probes_(kQueriesPerBlock * probes_per_query_),
        buckets_(kQueriesPerBlock * probes_per_query_),
        contents_(kQueriesPerBlock * probes_per_query_ + kProbesAhead),
        visited_(grids.descriptors_.size()) {}

  void LocateBuckets(size_t begin, size_t end) {
    const size_t num_probes = grids_.hasher_.num_probes();
    for (size_t query = begin; query < end; ++query) {
      const size_t first = (query - begin) * probes_per_query_;
      grids_.hasher_.FindProbes(queries_.row(query).data(), num_grids_,
                                CoordinatesOf(query - begin), &probes_[first]);
      for (size_t i = 0; i < probes_per_query_; ++i) {
        const BucketTable& table = *grids_.tables_[i / num_probes];
        buckets_[first + i] = table.BucketOf(probes_[first + i].hash);
        table.Prefetch(buckets_[first + i]);
      }
    }
  }

  void LocateContents(size_t num_queries) {
    const size_t num_probes = grids_.hasher_.num_probes();
    for (size_t i = 0; i < num_queries * probes_per_query_; ++i) {
      contents_[i] = (*grids_.tables_[i % probes_per_query_ / num_probes])[buckets_[i]];
      Prefetch(contents_[i]);
    }
  }

  // Distinct descriptors, of the cells of one query of the block, that may lie within
  // `max_sq_steps` of it.
  void GatherCandidates(size_t query_in_block, int32_t max_sq_steps,
                        std::vector<uint32_t>* candidates) {
    const size_t num_within = FilterCells(query_in_block, max_sq_steps);
    candidates->resize(num_within);
    const size_t stride = grids_.descriptors_.scale().stride();
    uint32_t* next = candidates->data();
    for (size_t i = 0; i < num_within; ++i) {
      const uint32_t item = within_[i];
      __builtin_prefetch(grids_.descriptors_.rows() + item * stride);
      *next = item;
      next += visited_.Insert(item) ? 1 : 0;  // Without a branch, which would be mispredicted.
    }
    candidates->resize(next - candidates->data());
    visited_.Erase(*candidates);
  }

  void AddHits(uint32_t query, const std::vector<uint32_t>& candidates, HitCollector* collector) {
    const ByteScale& scale = grids_.descriptors_.scale();
    sq_distances_.resize(std::max(sq_distances_.size(), candidates.size()));
    BestDistanceKernels().gather(steps_.data() + size_t{query} * scale.stride(),
                                 grids_.descriptors_.rows(), scale.stride(), candidates.data(),
                                 candidates.size(), sq_distances_.data());
    const int32_t max_sq_steps = collector->max_sq_steps(query);
    hits_.resize(std::max(hits_.size(), candidates.size()));
    size_t num_hits = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
      hits_[num_hits] = {candidates[i], sq_distances_[i]};
      num_hits += sq_distances_[i] <= max_sq_steps ? 1 : 0;  // Without a branch.
    }
    collector->Add(query, {hits_.data(), num_hits});
  }

 private:
  std::span<int32_t> CoordinatesOf(size_t query_in_block) {
    const size_t count = grids_.hasher_.num_coordinates();
    return {coordinates_.data() + query_in_block * count, count};
  }

  // Writes to within_ what the sketches do not tell to be beyond reach; returns the number.
  size_t FilterCells(size_t query_in_block, int32_t max_sq_steps) {
    const size_t num_probes = grids_.hasher_.num_probes();
    const int32_t max_sum =
        MaxSketchSum(max_sq_steps * sq_units_per_sq_step_, grids_.hasher_.num_hashed_dims());
    const SketchKernels& kernels = BestSketchKernels();
    size_t num_within = 0;
    for (int grid = 0; grid < num_grids_; ++grid) {
      tables_.SetQuery(grids_.hasher_.Coordinates(CoordinatesOf(query_in_block), grid));
      for (size_t i = 0; i < num_probes; ++i) {
        const size_t probe = query_in_block * probes_per_query_ + grid * num_probes + i;
        const BucketTable::Bucket& bucket = contents_[probe];
        Prefetch(contents_[probe + kProbesAhead]);
        within_.resize(std::max(within_.size(), num_within + bucket.items.size() + kSketchSlack));
        num_within +=
            kernels.filter(tables_.Across(probes_[probe].crossed_dims), tables_.num_pairs(),
                           max_sum, bucket.sketches.data(), bucket.items.data(),
                           bucket.items.size(), within_.data() + num_within);
      }
    }
    return num_within;
  }

  static void Prefetch(const BucketTable::Bucket& bucket) {
    const auto* bytes = reinterpret_cast<const char*>(bucket.sketches.data());
    for (size_t offset = 0; offset < 2 * bucket.sketches.size_bytes(); offset += kCacheLineBytes) {
      __builtin_prefetch(bytes + offset);
    }
  }

  // What was asked for with its block of queries has gone on to the second level of the cache; so
  // many probes before it is read it is asked for again.
  static constexpr size_t kProbesAhead = 8;

  const RandomGrids& grids_;
  const DescriptorMatrix& queries_;
  const std::vector<int16_t> steps_;  // Queries as ByteScale makes them.
  const int num_grids_;               // That stand.
  const size_t probes_per_query_;
  const double sq_units_per_sq_step_;
  std::vector<int32_t> coordinates_;           // kQueriesPerBlock x num_coordinates().
  std::vector<Probe> probes_;                  // kQueriesPerBlock x probes_per_query_.
  std::vector<uint32_t> buckets_;              // Likewise.
  std::vector<BucketTable::Bucket> contents_;  // Likewise; empty ones at the end.
  SketchTables tables_;
  std::vector<uint32_t> within_;
  DescriptorSet visited_;
  std::vector<int32_t> sq_distances_;
  std::vector<BlockHit> hits_;
};

RandomGrids::RandomGrids(const Codebook& codebook, std::span<const uint8_t> codes,
                         const RandomGridsOptions& options, BuildExtent extent)
    : codebook_(&codebook),
      codes_(codes),
      options_(options),
      descriptors_(codebook, codes),
      hasher_(codebook, options),
      tables_(options.num_grids) {
  do {
    RandomGrids::BuildPart();
  } while (extent == BuildExtent::kWhole && !RandomGrids::is_complete());
}

void RandomGrids::BuildPart() const {
  const std::lock_guard lock(mutex_);
  if (is_complete()) {
    return;
  }
  const int grid = num_standing();
  const CellHasher::CellPlaces places = hasher_.PlaceCodes(*codebook_, codes_, grid);
  tables_[grid].emplace(places.hashes, places.sketches, NumBucketBits(descriptors_.size()),
                        options_.max_candidates_per_cell, RandomBits(options_.seed, grid),
                        &scratch_);
  num_standing_.store(grid + 1, std::memory_order_release);
  if (is_complete()) {
    scratch_ = {};
  }
}

int64_t RandomGrids::Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const {
  HitCollector collector(descriptors_.scale(), request);
  const auto num_queries = static_cast<size_t>(request.queries.rows());
  Searcher searcher(*this, request.queries);
  // Two lists: one query's descriptors are on their way while the previous one's are compared.
  std::vector<uint32_t> candidates, next_candidates;
  int64_t num_distances = 0;
  for (size_t begin = 0; begin < num_queries && !collector.ShouldStop();
       begin += kQueriesPerBlock) {
    const size_t end = std::min(begin + kQueriesPerBlock, num_queries);
    searcher.LocateBuckets(begin, end);
    searcher.LocateContents(end - begin);
    searcher.GatherCandidates(0, collector.max_sq_steps(static_cast<uint32_t>(begin)), &candidates);
    for (size_t query = begin; query < end; ++query) {
      if (query + 1 < end) {
        searcher.GatherCandidates(query + 1 - begin,
                                  collector.max_sq_steps(static_cast<uint32_t>(query + 1)),
                                  &next_candidates);
      }
      searcher.AddHits(static_cast<uint32_t>(query), candidates, &collector);
      num_distances += static_cast<int64_t>(candidates.size());
      candidates.swap(next_candidates);
    }
  }
  collector.MoveTo(hits);
  return num_distances;
}

size_t RandomGrids::MemoryBytes() const {
  // All tables are of one size, and the first always stands.
  return descriptors_.MemoryBytes() + hasher_.MemoryBytes() +
         tables_.size() * tables_.front()->MemoryBytes();
}

}  // namespace cairn
