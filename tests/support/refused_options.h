// Options that are spoiled field by field.
#ifndef CAIRN_TESTS_SUPPORT_REFUSED_OPTIONS_H_
#define CAIRN_TESTS_SUPPORT_REFUSED_OPTIONS_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn::testing {

// The name of a field, and a change that makes the field invalid.
template <typename Options>
using SpoiledField = std::pair<const char*, std::function<void(Options*)>>;

// Expects that Validate accepts `good`, and refuses each case with Error(kInvalidArgument) that
// names the field.
template <typename Options>
void ExpectRefused(const Options& good, const std::vector<SpoiledField<Options>>& cases) {
  EXPECT_NO_THROW(good.Validate());
  for (const auto& [field, spoil] : cases) {
    Options options = good;
    spoil(&options);
    try {
      options.Validate();
      ADD_FAILURE() << field << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(field));
    }
  }
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_REFUSED_OPTIONS_H_
