// Helpers for tests of errors.
#ifndef CAIRN_TESTS_SUPPORT_EXPECT_ERROR_H_
#define CAIRN_TESTS_SUPPORT_EXPECT_ERROR_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>

#include "core/error.h"

namespace cairn::testing {

// Returns the code of the cairn::Error that `action` throws, or nullopt if it throws none.
template <typename Action>
std::optional<ErrorCode> ErrorCodeOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  return std::nullopt;
}

// Expects an error of that code whose message has `text`.
inline void ExpectError(const std::function<void()>& action, ErrorCode code,
                        const std::string& text) {
  try {
    action();
    ADD_FAILURE() << "no error; expected: " << text;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_THAT(error.what(), ::testing::HasSubstr(text));
  }
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_EXPECT_ERROR_H_
