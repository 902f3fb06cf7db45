#include "storage/codebook/codebook.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/error.h"
#include "support/map_builder.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::RandomCodebook;

Codebook SmallCodebook() {
  return RandomCodebook({.raw_dim = 3, .projected_dim = 2, .num_subspaces = 1});
}

std::optional<ErrorCode> DecodeResult(const std::vector<uint8_t>& bytes) {
  return ErrorCodeOf([&] { DecodeCodebook(bytes.data(), bytes.size(), CodebookId(1)); });
}

TEST(Codebook, RoundTripIsExact) {
  const Codebook codebook = RandomCodebook();
  const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
  const Codebook decoded = DecodeCodebook(bytes.data(), bytes.size(), CodebookId(7));
  EXPECT_EQ(decoded.id, CodebookId(7));
  EXPECT_EQ(decoded.descriptor_type, codebook.descriptor_type);
  EXPECT_EQ(decoded.normalization, codebook.normalization);
  EXPECT_EQ(decoded.mean, codebook.mean);
  EXPECT_EQ(decoded.projection, codebook.projection);
  EXPECT_EQ(decoded.num_subspaces, codebook.num_subspaces);
  EXPECT_EQ(decoded.words, codebook.words);
  EXPECT_EQ(decoded.same_landmark_distance_quantiles, codebook.same_landmark_distance_quantiles);
  EXPECT_EQ(decoded.other_landmark_distance_quantiles, codebook.other_landmark_distance_quantiles);
  EXPECT_EQ(EncodeCodebook(decoded), bytes);
}

TEST(Codebook, CodecNameSaysTypeDimensionsAndId) {
  Codebook codebook = RandomCodebook();
  codebook.id = CodebookId(3);
  EXPECT_EQ(codebook.CodecName(), "sift-128-16-3");
}

TEST(Codebook, RefusesToEncodeNonsense) {
  const auto expect_refused = [](const auto& spoil) {
    Codebook codebook = RandomCodebook();
    spoil(&codebook);
    EXPECT_EQ(ErrorCodeOf([&] { EncodeCodebook(codebook); }), ErrorCode::kBadInput);
  };
  expect_refused([](Codebook* c) { c->descriptor_type = ""; });
  expect_refused([](Codebook* c) { c->descriptor_type = "a-b"; });
  expect_refused([](Codebook* c) { c->num_subspaces = 0; });
  expect_refused([](Codebook* c) { c->num_subspaces = 5; });
  expect_refused([](Codebook* c) { c->words.pop_back(); });
  expect_refused([](Codebook* c) { c->words[100] = NAN; });
  expect_refused([](Codebook* c) { c->mean[0] = INFINITY; });
  expect_refused([](Codebook* c) { c->mean.resize(64); });
  expect_refused([](Codebook* c) { c->normalization = DescriptorNormalization(9); });
  expect_refused([](Codebook* c) {
    std::swap(c->same_landmark_distance_quantiles[0], c->same_landmark_distance_quantiles[1]);
  });
}

TEST(Codebook, EveryTruncationIsDamage) {
  const std::vector<uint8_t> bytes = EncodeCodebook(SmallCodebook());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(DecodeResult({bytes.begin(), bytes.begin() + size}), ErrorCode::kMapDamaged) << size;
  }
}

TEST(Codebook, EveryFlippedBitIsDamage) {
  std::vector<uint8_t> bytes = EncodeCodebook(SmallCodebook());
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= 1 << bit % 8;
    EXPECT_EQ(DecodeResult(bytes), ErrorCode::kMapDamaged) << "bit " << bit;
    bytes[bit / 8] ^= 1 << bit % 8;
  }
}

}  // namespace
}  // namespace cairn
