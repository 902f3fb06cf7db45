#include "ingest/codebook/transcoder.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "ingest/codebook/train_codebook.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

testing::StreetWorldOptions StreetOptionsWith(uint64_t seed) {
  testing::StreetWorldOptions options;
  options.length_m = 30.0;
  options.num_landmarks = 500;
  options.seed = seed;
  return options;
}

std::shared_ptr<const Codebook> CodebookOf(const Reconstruction& reconstruction,
                                           int num_subspaces = 8) {
  CodebookOptions options;
  options.num_subspaces = num_subspaces;
  return std::make_shared<const Codebook>(TrainCodebook(reconstruction, options));
}

TEST(Transcoder, ToTheSameCodebookChangesNothing) {
  const Reconstruction street = testing::StreetWorld(StreetOptionsWith(1)).Reconstruct();
  const auto codebook = CodebookOf(street);
  const DescriptorCodec codec(codebook);
  const std::vector<uint8_t> codes =
      codec.Encode(codec.Project(street.images[0].features.descriptors.Unpacked()));
  EXPECT_EQ(Transcoder(codebook, codebook).Transcode(codes), codes);
}

TEST(Transcoder, KeepsWhatBothProjectionsHold) {
  const Reconstruction street = testing::StreetWorld(StreetOptionsWith(1)).Reconstruct();
  const auto from = CodebookOf(street);
  CodebookOptions options;  // The same descriptors, with another permutation and other words.
  options.num_subspaces = 4;
  options.seed = 9;
  const auto to = std::make_shared<const Codebook>(TrainCodebook(street, options));
  const DescriptorCodec from_codec(from), to_codec(to);
  const DescriptorMatrix raw = street.images[0].features.descriptors.Unpacked();
  const std::vector<uint8_t> codes =
      Transcoder(from, to).Transcode(from_codec.Encode(from_codec.Project(raw)));
  ASSERT_EQ(codes.size(), static_cast<size_t>(4 * raw.rows()));
  const DescriptorMatrix wanted = to_codec.Project(raw);
  const DescriptorMatrix got = to_codec.Decode(codes.data(), static_cast<int>(raw.rows()));
  const double error = (got - wanted).squaredNorm();
  const double spread = (wanted.rowwise() - wanted.colwise().mean()).squaredNorm();
  EXPECT_LT(error, 0.5 * spread);
}

TEST(Transcoder, RefusesOtherDescriptors) {
  const Reconstruction street = testing::StreetWorld(StreetOptionsWith(1)).Reconstruct();
  const auto from = CodebookOf(street);
  Codebook other = *from;
  other.descriptor_type = "superpoint";
  EXPECT_NE(WhyNotTranscodable(*from, other), "");
  EXPECT_THROW(Transcoder(from, std::make_shared<const Codebook>(other)), Error);
  other = *from;
  other.normalization = DescriptorNormalization::kNone;
  EXPECT_NE(WhyNotTranscodable(*from, other), "");
  EXPECT_EQ(WhyNotTranscodable(*from, *from), "");
}

}  // namespace
}  // namespace cairn
