#include "cli/arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/printable.h"
#include "core/wire/header_line.h"

namespace cairn {
namespace {

// Blanks around the parts do not count.
std::vector<std::string_view> SplitAtCommas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const size_t comma = text.find(',');
    parts.push_back(TrimBlanks(text.substr(0, comma)));
    if (comma == std::string_view::npos) {
      return parts;
    }
    text.remove_prefix(comma + 1);
  }
}

// Returns nothing unless the whole text is a finite number.
std::optional<double> FiniteNumber(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

double ParseNumber(const std::string& option, std::string_view text) {
  const std::optional<double> value = FiniteNumber(text);
  if (!value) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' is not a finite number", option, Excerpt(text)));
  }
  return *value;
}

int ParsePixels(const std::string& option, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' is not a whole number of pixels", option, Excerpt(text)));
  }
  return value;
}

// Names the numbers of a position that are not there.
void RequireAllOfPosition(const std::string& option, const std::string& text, bool needs_height) {
  constexpr std::string_view kNames[] = {"latitude", "longitude", "height"};
  const std::string_view expected =
      needs_height ? "latitude, longitude and height" : "latitude, longitude and, if known, height";
  const std::vector<std::string_view> parts = SplitAtCommas(text);
  const size_t num_needed = needs_height || parts.size() > 2 ? 3 : 2;
  std::vector<std::string_view> missing;
  for (size_t i = 0; i < num_needed; ++i) {
    if (i >= parts.size() || parts[i].empty()) {
      missing.push_back(kNames[i]);
    }
  }
  if (!missing.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected {}, separated by commas; '{}' lacks the {}", option,
                            expected, Excerpt(text), fmt::join(missing, " and the ")));
  }
  if (parts.size() > std::size(kNames)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected {}, separated by commas; '{}' has {} numbers. Write "
                            "decimals with a point",
                            option, expected, Excerpt(text), parts.size()));
  }
}

Geodetic ParsePosition(const std::string& option, const std::string& text, bool needs_height) {
  RequireAllOfPosition(option, text, needs_height);
  const std::vector<double> numbers = ParseNumbers(option, text, 0);
  const double h_m = numbers.size() > 2 ? numbers[2] : 0.0;
  const Geodetic position = Geodetic::FromDegrees(numbers[0], numbers[1], h_m);
  try {
    ValidateGeodetic(position, option.c_str());
  } catch (const Error& error) {
    throw Error(ErrorCode::kInvalidArgument, error.what());
  }
  return position;
}

}  // namespace

CLI::Validator NumberWithin(double min, double max) {
  return CLI::Validator(
      [min, max](std::string& text) {
        const std::optional<double> value = FiniteNumber(text);
        return value && *value >= min && *value <= max
                   ? std::string()
                   : fmt::format("'{}' is not a number from {} to {}", Excerpt(text), min, max);
      },
      "");
}

CLI::Validator PositiveNumber() {
  return CLI::Validator(
      [](std::string& text) {
        const std::optional<double> value = FiniteNumber(text);
        return value && *value > 0.0 ? std::string()
                                     : fmt::format("'{}' is not a number above 0", Excerpt(text));
      },
      "");
}

void AddCaOption(CLI::App* command, CLI::Option* server, std::string* ca_file) {
  command
      ->add_option("--ca", *ca_file,
                   "Certificates to trust for an https URL, PEM. Default: those of the system")
      ->type_name("FILE")
      ->needs(server);
}

void AddSeedOption(CLI::App* command, uint64_t* seed, const std::string& description) {
  const auto check = [](std::string& text) {
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_whole = error == std::errc() && end == text.data() + text.size();
    return is_whole ? std::string()
                    : fmt::format("'{}' is not a whole number from 0 to 2^64 - 1", Excerpt(text));
  };
  command->add_option("--seed", *seed, description)
      ->check(CLI::Validator(check, ""))
      ->capture_default_str();
}

std::vector<double> ParseNumbers(const std::string& option, const std::string& text, int count) {
  std::vector<double> numbers;
  for (const std::string_view part : SplitAtCommas(text)) {
    numbers.push_back(ParseNumber(option, part));
  }
  if (count != 0 && static_cast<int>(numbers.size()) != count) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected {} numbers separated by commas, got {} in '{}'", option,
                            count, numbers.size(), Excerpt(text)));
  }
  return numbers;
}

Camera ParseCamera(const std::string& option, const std::string& text) {
  const std::vector<std::string_view> parts = SplitAtCommas(text);
  if (parts.size() < 4) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: expected MODEL,width,height,param,... got '{}'", option, Excerpt(text)));
  }
  const int width_px = ParsePixels(option, parts[1]);
  const int height_px = ParsePixels(option, parts[2]);
  std::vector<double> params;
  for (size_t i = 3; i < parts.size(); ++i) {
    params.push_back(ParseNumber(option, parts[i]));
  }
  try {
    return Camera(CameraModelFromName(parts[0]), width_px, height_px, params);
  } catch (const Error& error) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", option, error.what()));
  }
}

Geodetic ParseGeodetic(const std::string& option, const std::string& text) {
  return ParsePosition(option, text, /*needs_height=*/true);
}

Geodetic ParsePlace(const std::string& option, const std::string& text) {
  return ParsePosition(option, text, /*needs_height=*/false);
}

Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text) {
  const std::vector<double> numbers = ParseNumbers(option, text, 3);
  const Eigen::Vector3d direction(numbers[0], numbers[1], numbers[2]);
  if (direction.norm() < 1e-9) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' has no direction", option, Excerpt(text)));
  }
  return direction.normalized();
}

}  // namespace cairn
