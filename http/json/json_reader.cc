#include "http/json/json_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "http/problem.h"

namespace cairn {
namespace {

constexpr int kMaxDepth = 16;

// Escapes a member name for a JSON pointer.
std::string EscapePointer(std::string_view member) {
  std::string escaped;
  for (const char c : member) {
    if (c == '~') {
      escaped += "~0";
    } else if (c == '/') {
      escaped += "~1";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace

nlohmann::json ParseJson(std::string_view text) {
  using Event = nlohmann::json::parse_event_t;
  const auto check_depth = [](int depth, Event event, nlohmann::json&) {
    const bool opens = event == Event::object_start || event == Event::array_start;
    if (opens && depth >= kMaxDepth) {
      throw HttpError(ProblemCode::kInvalidJson,
                      fmt::format("the JSON is nested deeper than {}", kMaxDepth));
    }
    return true;
  };
  try {
    return nlohmann::json::parse(text.begin(), text.end(), check_depth);
  } catch (const nlohmann::json::parse_error& e) {
    // The library's message quotes the input, which may be long and need not be text.
    throw HttpError(ProblemCode::kInvalidJson,
                    fmt::format("the JSON does not parse at byte {} of {}", e.byte, text.size()));
  } catch (const nlohmann::json::exception&) {
    throw HttpError(ProblemCode::kInvalidJson, "the JSON has a number that is out of range");
  }
}

void JsonReader::Fail(const std::string& detail, const std::string& hint) const {
  throw HttpError(ProblemCode::kInvalidField,
                  fmt::format("{}: {}", pointer_.empty() ? "the top level" : pointer_, detail))
      .At(pointer_)
      .Hint(hint);
}

void JsonReader::RequireObject() const {
  if (!value_->is_object()) Fail("has to be an object");
}

void JsonReader::RequireOnly(std::initializer_list<std::string_view> members) const {
  RequireObject();
  for (const auto& [name, value] : value_->items()) {
    if (std::find(members.begin(), members.end(), name) == members.end()) {
      JsonReader(value, fmt::format("{}/{}", pointer_, EscapePointer(name)))
          .Fail("is not a member this server knows",
                fmt::format("known here: {}", fmt::join(members, ", ")));
    }
  }
}

bool JsonReader::Has(std::string_view member) const { return Find(member).has_value(); }

std::optional<JsonReader> JsonReader::Find(std::string_view member) const {
  RequireObject();
  const auto it = value_->find(member);
  if (it == value_->end() || it->is_null()) return std::nullopt;
  return JsonReader(*it, fmt::format("{}/{}", pointer_, EscapePointer(member)));
}

JsonReader JsonReader::At(std::string_view member) const {
  const std::optional<JsonReader> found = Find(member);
  if (found) return *found;
  JsonReader(*value_, fmt::format("{}/{}", pointer_, EscapePointer(member))).Fail("is missing");
}

std::vector<JsonReader> JsonReader::Elements(size_t min_size, size_t max_size) const {
  if (!value_->is_array() || value_->size() < min_size || value_->size() > max_size) {
    Fail(min_size == max_size ? fmt::format("has to be an array of {}", min_size)
                              : fmt::format("has to be an array of {} to {}", min_size, max_size));
  }
  std::vector<JsonReader> elements;
  for (size_t i = 0; i < value_->size(); ++i) {
    elements.push_back(JsonReader((*value_)[i], fmt::format("{}/{}", pointer_, i)));
  }
  return elements;
}

std::vector<double> JsonReader::Numbers(size_t min_size, size_t max_size) const {
  constexpr double kMax = std::numeric_limits<double>::max();
  std::vector<double> numbers;
  for (const JsonReader& element : Elements(min_size, max_size)) {
    numbers.push_back(element.Number(-kMax, kMax));
  }
  return numbers;
}

bool JsonReader::IsArray() const { return value_->is_array(); }

bool JsonReader::Bool() const {
  if (!value_->is_boolean()) Fail("has to be true or false");
  return value_->get<bool>();
}

double JsonReader::Number(double min, double max) const {
  if (!value_->is_number()) Fail("has to be a number");
  const auto number = value_->get<double>();
  if (!(number >= min && number <= max)) {
    Fail(fmt::format("is {}, outside [{}, {}]", number, min, max));
  }
  return number;
}

int64_t JsonReader::Integer(int64_t min, int64_t max) const {
  const double number = Number(static_cast<double>(min), static_cast<double>(max));
  if (number != std::floor(number)) Fail("has to be an integer");
  return static_cast<int64_t>(number);
}

const std::string& JsonReader::String() const {
  if (!value_->is_string()) Fail("has to be a string");
  return value_->get_ref<const std::string&>();
}

const std::string& JsonReader::String(size_t max_length) const {
  const std::string& text = String();
  if (text.size() > max_length) Fail(fmt::format("is longer than {} bytes", max_length));
  return text;
}

}  // namespace cairn
