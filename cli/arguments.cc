#include "cli/arguments.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

#include "core/error.h"

namespace cairn {
namespace {

std::vector<std::string_view> SplitAtCommas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const size_t comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) {
      return parts;
    }
    text.remove_prefix(comma + 1);
  }
}

double ParseNumber(const std::string& option, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' is not a finite number", option, text));
  }
  return value;
}

int ParsePixels(const std::string& option, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' is not a whole number of pixels", option, text));
  }
  return value;
}

}  // namespace

std::vector<double> ParseNumbers(const std::string& option, const std::string& text, int count) {
  std::vector<double> numbers;
  for (const std::string_view part : SplitAtCommas(text)) {
    numbers.push_back(ParseNumber(option, part));
  }
  if (count != 0 && static_cast<int>(numbers.size()) != count) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected {} numbers separated by commas, got {} in '{}'", option,
                            count, numbers.size(), text));
  }
  return numbers;
}

Camera ParseCamera(const std::string& option, const std::string& text) {
  const std::vector<std::string_view> parts = SplitAtCommas(text);
  if (parts.size() < 4) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected MODEL,width,height,param,... got '{}'", option, text));
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
  const std::vector<double> numbers = ParseNumbers(option, text, 3);
  const Geodetic position = Geodetic::FromDegrees(numbers[0], numbers[1], numbers[2]);
  try {
    ValidateGeodetic(position, option.c_str());
  } catch (const Error& error) {
    throw Error(ErrorCode::kInvalidArgument, error.what());
  }
  return position;
}

Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text) {
  const std::vector<double> numbers = ParseNumbers(option, text, 3);
  const Eigen::Vector3d direction(numbers[0], numbers[1], numbers[2]);
  if (direction.norm() < 1e-9) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: '{}' has no direction", option, text));
  }
  return direction.normalized();
}

}  // namespace cairn
