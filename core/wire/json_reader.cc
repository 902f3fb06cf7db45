#include "core/wire/json_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/printable.h"
#include "core/wire/json_error.h"

namespace cairn {
namespace {

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

void JsonReader::Fail(const std::string& detail, const std::string& hint) const {
  throw JsonError(fmt::format("{}: {}", pointer_.empty() ? "the top level" : pointer_, detail),
                  pointer_, hint);
}

template <typename Visit>
void JsonReader::ForEachChild(const Visit& visit) const {
  if (value().num_children == 0) {
    return;
  }
  for (size_t child = index_ + 1; child != 0; child = (*document_)[child].next) {
    visit(child);
  }
}

void JsonReader::RequireObject() const {
  if (!IsObject()) {
    Fail("must be an object");
  }
}

void JsonReader::RequireOnly(std::initializer_list<std::string_view> members) const {
  RequireObject();
  ForEachChild([&](size_t child) {
    const std::string& name = (*document_)[child].name;
    if (std::find(members.begin(), members.end(), name) == members.end()) {
      Member(child, Excerpt(name))
          .Fail("is an unknown member", fmt::format("known members: {}", fmt::join(members, ", ")));
    }
  });
}

JsonReader JsonReader::Member(size_t index, std::string_view name) const {
  return JsonReader(*document_, index, fmt::format("{}/{}", pointer_, EscapePointer(name)));
}

bool JsonReader::Has(std::string_view member) const { return Find(member).has_value(); }

std::optional<JsonReader> JsonReader::Find(std::string_view member) const {
  RequireObject();
  std::optional<JsonReader> found;
  ForEachChild([&](size_t child) {
    const JsonValue& candidate = (*document_)[child];
    if (candidate.name == member && candidate.kind != JsonValue::Kind::kNull) {
      found = Member(child, member);
    }
  });
  return found;
}

JsonReader JsonReader::At(std::string_view member) const {
  const std::optional<JsonReader> found = Find(member);
  if (found) {
    return *found;
  }
  Member(index_, member).Fail("is missing");
}

std::vector<JsonReader> JsonReader::Elements(size_t min_size, size_t max_size) const {
  const size_t size = value().num_children;
  if (!IsArray() || size < min_size || size > max_size) {
    Fail(min_size == max_size ? fmt::format("must be an array of {}", min_size)
                              : fmt::format("must be an array of {} to {}", min_size, max_size));
  }
  std::vector<JsonReader> elements;
  ForEachChild([&](size_t child) {
    elements.push_back(
        JsonReader(*document_, child, fmt::format("{}/{}", pointer_, elements.size())));
  });
  return elements;
}

std::vector<double> JsonReader::Numbers(size_t min_size, size_t max_size) const {
  std::vector<double> numbers;
  for (const JsonReader& element : Elements(min_size, max_size)) {
    numbers.push_back(element.Number());
  }
  return numbers;
}

bool JsonReader::IsArray() const { return value().kind == JsonValue::Kind::kArray; }
bool JsonReader::IsObject() const { return value().kind == JsonValue::Kind::kObject; }
bool JsonReader::IsString() const { return value().kind == JsonValue::Kind::kString; }

bool JsonReader::Bool() const {
  if (value().kind != JsonValue::Kind::kBool) {
    Fail("must be true or false");
  }
  return value().number != 0.0;
}

double JsonReader::Number() const {
  if (value().kind != JsonValue::Kind::kNumber) {
    Fail("must be a number");
  }
  return value().number;
}

double JsonReader::Number(double min, double max) const {
  const double number = Number();
  if (!(number >= min && number <= max)) {
    Fail(fmt::format("is {}, outside [{}, {}]", number, min, max));
  }
  return number;
}

int64_t JsonReader::Integer(int64_t min, int64_t max) const {
  const double number = Number(static_cast<double>(min), static_cast<double>(max));
  if (number != std::floor(number)) {
    Fail("must be an integer");
  }
  return static_cast<int64_t>(number);
}

const std::string& JsonReader::String() const {
  if (!IsString()) {
    Fail("must be a string");
  }
  return value().text;
}

const std::string& JsonReader::String(size_t max_length) const {
  const std::string& text = String();
  if (text.size() > max_length) {
    Fail(fmt::format("is longer than {} bytes", max_length));
  }
  return text;
}

}  // namespace cairn
