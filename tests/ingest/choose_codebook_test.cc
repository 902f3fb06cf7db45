#include "ingest/codebook/choose_codebook.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "ingest/codebook/shipped_codebook.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

Reconstruction StreetOf(int descriptor_dim = 128) {
  testing::StreetWorldOptions options;
  options.length_m = 30.0;
  options.num_landmarks = 500;
  options.descriptor_dim = descriptor_dim;
  return testing::StreetWorld(options).Reconstruct();
}

ErrorCode CodeOf(const Reconstruction& reconstruction, const CodebookOptions& options) {
  try {
    ChooseCodebook(reconstruction, options);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::kInternal;
}

TEST(ShippedCodebook, HasTheShapeOfTheDefaults) {
  const auto shipped = ShippedCodebook();
  const CodebookOptions defaults;
  EXPECT_NO_THROW(shipped->Validate());
  EXPECT_EQ(shipped->descriptor_type, "sift");
  EXPECT_EQ(shipped->raw_dim(), 128);
  EXPECT_EQ(shipped->projected_dim(), defaults.projected_dim);
  EXPECT_EQ(shipped->num_subspaces, defaults.num_subspaces);
  EXPECT_EQ(shipped->same_landmark_distance_quantiles.size(), 19u);
}

TEST(ChooseCodebook, TakesTheShippedOneForASmallSession) {
  CodebookOptions options;
  options.min_training_descriptors = 1'000'000;
  EXPECT_TRUE(IsShipped(*ChooseCodebook(StreetOf(), options)));
}

TEST(ChooseCodebook, TrainsOnALargeSession) {
  EXPECT_FALSE(IsShipped(*ChooseCodebook(StreetOf(), CodebookOptions())));
}

TEST(ChooseCodebook, FollowsTheSourceWhateverTheSize) {
  CodebookOptions options;
  options.source = CodebookSource::kTrained;
  options.min_training_descriptors = 1'000'000;
  EXPECT_FALSE(IsShipped(*ChooseCodebook(StreetOf(), options)));
  options.source = CodebookSource::kShipped;
  options.min_training_descriptors = 0;
  EXPECT_TRUE(IsShipped(*ChooseCodebook(StreetOf(), options)));
}

TEST(ChooseCodebook, TrainsWhatTheShippedOneDoesNotFit) {
  CodebookOptions options;
  options.min_training_descriptors = 1'000'000;
  options.num_subspaces = 4;
  EXPECT_FALSE(IsShipped(*ChooseCodebook(StreetOf(), options)));
  EXPECT_FALSE(IsShipped(*ChooseCodebook(StreetOf(64), options)));
}

TEST(ChooseCodebook, RefusesTheShippedOneWhereItDoesNotFit) {
  CodebookOptions options;
  options.source = CodebookSource::kShipped;
  EXPECT_EQ(CodeOf(StreetOf(64), options), ErrorCode::kBadInput);
  options.num_subspaces = 4;
  EXPECT_EQ(CodeOf(StreetOf(), options), ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace cairn
