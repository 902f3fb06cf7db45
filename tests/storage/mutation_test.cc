// Tests hostile bytes with a valid checksum, which an attacker can compute. Deterministic.
#include <gtest/gtest.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "core/error.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/checksum.h"
#include "storage/tile/tile_codec.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr size_t kHeaderSize = 72;
constexpr size_t kTileChecksumOffset = 64;
constexpr size_t kDirectorySize = 66 * sizeof(uint32_t);
constexpr size_t kCodebookChecksumOffset = 32;

void Seal(std::vector<uint8_t>* bytes, size_t checksum_offset) {
  const uint64_t checksum = ChecksumOf(*bytes, checksum_offset);
  std::memcpy(bytes->data() + checksum_offset, &checksum, sizeof(checksum));
}

// A few random bytes changed, among them values at the edges of what integers hold.
void Mutate(std::mt19937_64* random, std::vector<uint8_t>* bytes) {
  constexpr uint8_t kEdges[] = {0x00, 0x01, 0x7f, 0x80, 0xff};
  const size_t num_changes = 1 + (*random)() % 4;
  for (size_t i = 0; i < num_changes && !bytes->empty(); ++i) {
    uint8_t& byte = (*bytes)[(*random)() % bytes->size()];
    byte = (*random)() % 2 == 0 ? kEdges[(*random)() % std::size(kEdges)]
                                : static_cast<uint8_t>((*random)());
  }
}

struct Outcome {
  int num_decoded = 0;
  int num_refused = 0;
};

// Decodes; what decodes must be consistent and be encoded again, what does not must be damage.
void DecodeHostileTile(const std::vector<uint8_t>& blob, Outcome* outcome) {
  const TileDecodeLimits limits{.max_decoded_bytes = 1 << 24};
  try {
    TileLists lists, again;
    const Tile tile = DecodeTile(blob, limits, &lists);
    EXPECT_TRUE(testing::SameTile(DecodeTile(EncodeTile(tile, lists), limits, &again), tile));
    EXPECT_EQ(lists, again);
    const std::set<uint32_t> members(lists.members.begin(), lists.members.end());
    EXPECT_EQ(members.size(), lists.empty() ? 0 : tile.num_descriptors());
    ++outcome->num_decoded;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMapDamaged) << error.what();
    ++outcome->num_refused;
  }
}

std::vector<uint8_t> SmallBlob(Tile* tile) {
  testing::RandomTileOptions options;
  options.num_landmarks = 12;
  options.num_keyframes = 3;
  options.num_landmarks_per_keyframe = 8;
  *tile = testing::RandomTile(options);
  return EncodeTile(*tile);
}

TileLists SmallLists(const Tile& tile) {
  TileLists lists;
  lists.members.resize(tile.num_descriptors());
  std::iota(lists.members.begin(), lists.members.end(), 0u);
  lists.begin = {0, 3, 3, 10, static_cast<uint32_t>(lists.members.size())};
  return lists;
}

// Mutates the bytes in [begin, end) and seals the payload again.
Outcome DecodeMutated(const std::vector<uint8_t>& blob, size_t begin, size_t end, uint64_t seed,
                      int num_trials = 5'000) {
  std::mt19937_64 random(seed);
  Outcome outcome;
  for (int trial = 0; trial < num_trials; ++trial) {
    std::vector<uint8_t> part(blob.begin() + static_cast<ptrdiff_t>(begin),
                              blob.begin() + static_cast<ptrdiff_t>(end));
    Mutate(&random, &part);
    std::vector<uint8_t> mutated = blob;
    std::copy(part.begin(), part.end(), mutated.begin() + static_cast<ptrdiff_t>(begin));
    Seal(&mutated, kTileChecksumOffset);
    DecodeHostileTile(mutated, &outcome);
  }
  return outcome;
}

TEST(Mutation, TilesWithAValidChecksum) {
  Tile tile;
  std::vector<uint8_t> blob = SmallBlob(&tile);
  for (const TileLists& lists : {TileLists(), SmallLists(tile)}) {
    blob = EncodeTile(tile, lists);
    const Outcome outcome = DecodeMutated(blob, 0, blob.size(), 1);
    EXPECT_GT(outcome.num_decoded, 100);  // Changed codes are as good as others.
    EXPECT_GT(outcome.num_refused, 100);
  }
}

TEST(Mutation, TileDirectoriesWithAValidChecksum) {
  Tile tile;
  SmallBlob(&tile);
  const Outcome outcome = DecodeMutated(EncodeTile(tile, SmallLists(tile)), kHeaderSize,
                                        kHeaderSize + kDirectorySize, 2);
  EXPECT_GT(outcome.num_decoded, 10);  // A byte may become what it was.
  EXPECT_GT(outcome.num_refused, 1'000);
}

// The columns of so small a tile are stored as they are or as the one byte that they consist of, so
// that the mutations reach the numbers.
TEST(Mutation, TileColumnsWithAValidChecksum) {
  Tile tile;
  SmallBlob(&tile);
  const std::vector<uint8_t> blob = EncodeTile(tile, SmallLists(tile));
  const Outcome outcome =
      DecodeMutated(blob, kHeaderSize + kDirectorySize + tile.codes.size(), blob.size(), 3);
  EXPECT_GT(outcome.num_decoded, 100);
  EXPECT_GT(outcome.num_refused, 100);
}

// As many landmarks as it takes for their indices to be read several at a time.
TEST(Mutation, ObservationsOfManyLandmarksWithAValidChecksum) {
  testing::RandomTileOptions options;
  options.num_landmarks = 3'000;
  options.num_landmarks_per_keyframe = 1'400;
  const std::vector<uint8_t> blob = EncodeTile(testing::RandomTile(options));
  uint32_t observations_size = 0;
  std::memcpy(&observations_size, blob.data() + kHeaderSize + kDirectorySize - sizeof(uint32_t),
              sizeof(observations_size));
  const Outcome outcome =
      DecodeMutated(blob, blob.size() - observations_size, blob.size(), 7, 1'000);
  EXPECT_GT(outcome.num_decoded, 20);
  EXPECT_GT(outcome.num_refused, 20);
}

// Columns that are compressed.
TEST(Mutation, TileFramesWithAValidChecksum) {
  testing::RandomTileOptions options;
  options.num_landmarks = 300;
  const Tile tile = testing::RandomTile(options);
  const std::vector<uint8_t> blob = EncodeTile(tile);
  const Outcome outcome =
      DecodeMutated(blob, kHeaderSize + kDirectorySize + tile.codes.size(), blob.size(), 4);
  EXPECT_GT(outcome.num_decoded, 100);
  EXPECT_GT(outcome.num_refused, 100);
}

TEST(Mutation, CodebooksWithAValidChecksum) {
  const std::vector<uint8_t> bytes = EncodeCodebook(
      testing::RandomCodebook({.raw_dim = 3, .projected_dim = 2, .num_subspaces = 1}));
  std::mt19937_64 random(3);
  Outcome outcome;
  for (int trial = 0; trial < 5'000; ++trial) {
    std::vector<uint8_t> mutated = bytes;
    // Half of the changes hit the header.
    std::vector<uint8_t> head(mutated.begin(), mutated.begin() + 60);
    Mutate(&random, trial % 2 == 0 ? &head : &mutated);
    if (trial % 2 == 0) {
      std::copy(head.begin(), head.end(), mutated.begin());
    }
    Seal(&mutated, kCodebookChecksumOffset);
    try {
      DecodeCodebook(mutated.data(), mutated.size(), CodebookId(1)).Validate();
      ++outcome.num_decoded;
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::kMapDamaged) << error.what();
      ++outcome.num_refused;
    }
  }
  EXPECT_GT(outcome.num_decoded, 100);
  EXPECT_GT(outcome.num_refused, 100);
}

TEST(Mutation, RandomBytesAreDamage) {
  std::mt19937_64 random(4);
  Outcome outcome;
  for (int trial = 0; trial < 2'000; ++trial) {
    std::vector<uint8_t> bytes(random() % 300);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<uint8_t>(random()); });
    DecodeHostileTile(bytes, &outcome);
    EXPECT_THROW(DecodeCodebook(bytes.data(), bytes.size(), CodebookId(1)), Error);
  }
  EXPECT_EQ(outcome.num_decoded, 0);
}

// A column of one byte stands for as many as the header announces.
TEST(Mutation, CountsThatAnnounceGigabytesAreRefusedBeforeTheyAreUnpacked) {
  constexpr size_t kCountsOffset = 24;
  Tile tile;
  const std::vector<uint8_t> blob = SmallBlob(&tile);
  for (size_t count = 0; count < 4; ++count) {
    std::vector<uint8_t> mutated = blob;
    const uint32_t huge = UINT32_MAX;
    std::memcpy(mutated.data() + kCountsOffset + count * sizeof(huge), &huge, sizeof(huge));
    Seal(&mutated, kTileChecksumOffset);
    EXPECT_THROW(DecodeTile(mutated), Error);
  }
}

}  // namespace
}  // namespace cairn
