// What a struct of options tells about its members: the name, the values that make sense, and a
// line for people. A function VisitOptions beside the struct has it all, once; the check, the
// options file, the page docs/options.md, a stored plan and a digest go through it.
//
//   template <OptionsOf<FadeOptions> Options, typename Visitor>
//   void VisitOptions(Options& options, const Visitor& visitor) {
//     auto& [share] = options;  // Names all members; a new one that is not here does not compile.
//     visitor.Visit("share", share, WithinOf(0.0, 1.0), "Share of it that fades");
//   }
//
// A member that is such a struct itself is a section: visitor.Section("fade", fade, "How ...").
#ifndef CAIRN_CORE_OPTION_VISIT_H_
#define CAIRN_CORE_OPTION_VISIT_H_

#include <fmt/format.h>

#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/error.h"

namespace cairn {

// `Visited` is `Options`, const or not.
template <typename Visited, typename Options>
concept OptionsOf = std::same_as<std::remove_const_t<Visited>, Options>;

// The values of a number that make sense.
struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool has_min = true;  // `min` itself makes sense.
  bool has_max = true;

  // NaN is in no range.
  bool Contains(double value) const {
    return (has_min ? value >= min : value > min) && (has_max ? value <= max : value < max);
  }
  // "at least 1", "above 0", "in [0, 1)".
  std::string ToString() const {
    if (std::isinf(max)) {
      return fmt::format("{} {}{}", has_min ? "at least" : "above", min,
                         has_max ? "" : " and finite");
    }
    return fmt::format("in {}{}, {}{}", has_min ? '[' : '(', min, max, has_max ? ']' : ')');
  }
};

inline OptionRange AnyValue() { return {}; }
inline OptionRange AtLeast(double min) { return {.min = min}; }
inline OptionRange Above(double min) { return {.min = min, .has_min = false}; }
inline OptionRange FiniteFrom(double min) { return {.min = min, .has_max = false}; }
inline OptionRange WithinOf(double min, double max) { return {.min = min, .max = max}; }

// Visits the options of a struct and of its sections to check them.
class OptionChecker {
 public:
  explicit OptionChecker(std::string section) : section_(std::move(section)) {}

  template <typename T>
  void Visit(std::string_view name, const T& value, const OptionRange& range,
             std::string_view /*meaning*/) const {
    if constexpr (std::is_arithmetic_v<T>) {
      if (!range.Contains(static_cast<double>(value))) {
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}.{} = {} must be {}", section_, name, value, range.ToString()));
      }
    }
  }
  template <typename Options>
  void Section(std::string_view name, const Options& options, std::string_view /*meaning*/) const {
    VisitOptions(options, OptionChecker(fmt::format("{}.{}", section_, name)));
  }

 private:
  std::string section_;
};

// Throws Error(kInvalidArgument) that names the option unless all options are in their ranges.
// `section` is the dotted name of the struct, as in the options file.
template <typename Options>
void CheckOptions(std::string section, const Options& options) {
  VisitOptions(options, OptionChecker(std::move(section)));
}

}  // namespace cairn

#endif  // CAIRN_CORE_OPTION_VISIT_H_
