#include "lab/rivals/index_methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// The message with which these options are refused; empty if they are taken.
std::string Refusal(IndexMethod method, const IndexMethodOptions& options) {
  try {
    MakeIndexOptions(method, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "";
}

TEST(IndexMethods, OptionsOutOfRangeAreRefusedByName) {
  constexpr IndexMethod kMultiIndex = IndexMethod::kInvertedMultiIndex;
  EXPECT_THAT(Refusal(kMultiIndex, {.multi_index = {.num_words = 4097}}),
              HasSubstr("multi_index.num_words"));
  EXPECT_THAT(Refusal(kMultiIndex, {.multi_index = {.num_probes = 0}}),
              HasSubstr("multi_index.num_probes"));
  EXPECT_THAT(Refusal(kMultiIndex, {.multi_index = {.num_iterations = 101}}),
              HasSubstr("multi_index.num_iterations"));
  EXPECT_THAT(Refusal(IndexMethod::kKdTree, {.kd_tree = {.max_leaf_size = 0}}),
              HasSubstr("kd_tree.max_leaf_size"));
  EXPECT_THAT(Refusal(IndexMethod::kKdTree, {.kd_tree = {.num_probes = 0}}),
              HasSubstr("kd_tree.num_probes"));
}

TEST(IndexMethods, FactoriesAreNamedByTheirSettings) {
  const auto name = [](IndexMethod method, const IndexMethodOptions& options) {
    return MakeIndexOptions(method, options).other->name();
  };
  EXPECT_EQ(name(IndexMethod::kKdTree, {}), name(IndexMethod::kKdTree, {}));
  EXPECT_NE(name(IndexMethod::kKdTree, {}),
            name(IndexMethod::kKdTree, {.kd_tree = {.num_probes = 65}}));
  EXPECT_NE(name(IndexMethod::kInvertedMultiIndex, {}),
            name(IndexMethod::kInvertedMultiIndex, {.multi_index = {.seed = 2}}));
}

}  // namespace
}  // namespace cairn
