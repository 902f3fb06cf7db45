#include "cli/options/read_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cli/options/nearest_name.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"
#include "core/require.h"
#include "core/wire/json_document.h"

namespace cairn {
namespace {

// A file with every option is about a tenth of this.
constexpr size_t kMaxOptionsBytes = size_t{64} << 10;

// Above it a JSON number does not hold every integer.
constexpr double kMaxInteger = 9007199254740992.0;  // 2^53.

// More than an options file needs.
constexpr JsonLimits kLimits = {.max_values = 1000, .max_elements = 16, .max_depth = 8};

const char* KindName(JsonValue::Kind kind) {
  switch (kind) {
    case JsonValue::Kind::kNull:
      return "null";
    case JsonValue::Kind::kBool:
      return "a truth value";
    case JsonValue::Kind::kNumber:
      return "a number";
    case JsonValue::Kind::kString:
      return "a string";
    case JsonValue::Kind::kArray:
      return "an array";
    case JsonValue::Kind::kObject:
      return "an object";
  }
  return "";
}

std::string_view LastPart(std::string_view name) {
  return name.substr(name.find_last_of('.') + 1);  // All of it without a dot.
}

// Edit distance of two names, or of their last parts plus 1 if they are in different sections.
size_t Unlikeness(std::string_view a, std::string_view b) {
  return std::min(EditDistance(a, b), EditDistance(LastPart(a), LastPart(b)) + 1);
}

[[noreturn]] void Refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

[[noreturn]] void RefuseKind(const std::string& name, const char* wanted, const JsonValue& value) {
  Refuse(fmt::format("{} must be {}, not {}", name, wanted, KindName(value.kind)));
}

template <typename Integer>
void Set(const std::string& name, const JsonValue& value, Integer* integer) {
  if (value.kind != JsonValue::Kind::kNumber || value.number != std::floor(value.number)) {
    if (value.kind != JsonValue::Kind::kNumber) {
      RefuseKind(name, "a whole number", value);
    }
    Refuse(fmt::format("{} = {} must be a whole number", name, value.number));
  }
  constexpr double kMin =
      std::max(-kMaxInteger, static_cast<double>(std::numeric_limits<Integer>::min()));
  constexpr double kMax =
      std::min(kMaxInteger, static_cast<double>(std::numeric_limits<Integer>::max()));
  RequireWithin(name, value.number, kMin, kMax);
  *integer = static_cast<Integer>(value.number);
}

void Set(const std::string& name, const JsonValue& value, double* number) {
  if (value.kind == JsonValue::Kind::kString && value.text == "infinity") {
    *number = std::numeric_limits<double>::infinity();
    return;
  }
  if (value.kind != JsonValue::Kind::kNumber) {
    RefuseKind(name, "a number or \"infinity\"", value);
  }
  *number = value.number;
}

void Set(const std::string& name, const JsonValue& value, NamedChoice* choice) {
  if (value.kind != JsonValue::Kind::kString) {
    RefuseKind(name, "a string", value);
  }
  if (!choice->Set(value.text)) {
    Refuse(fmt::format("{} = \"{}\" must be one of \"{}\"", name, Excerpt(value.text),
                       fmt::join(choice->names(), "\", \"")));
  }
}

class OptionsReader {
 public:
  OptionsReader(const JsonDocument& document, OptionList* list)
      : document_(document), list_(*list) {}

  // Sets what the object at `index` holds, which is the section of that name.
  void ReadSection(size_t index, const std::string& section) {
    const JsonValue& object = document_[index];
    if (object.kind != JsonValue::Kind::kObject) {
      RefuseKind(section.empty() ? "the top level" : section, "an object", object);
    }
    if (object.num_children == 0) {
      return;
    }
    for (size_t child = index + 1; child != 0; child = document_[child].next) {
      ReadMember(child, section);
    }
  }

 private:
  void ReadMember(size_t index, const std::string& section) {
    const std::string& member = document_[index].name;
    const std::string name = section.empty() ? member : section + "." + member;
    if (member.find('.') != std::string::npos) {
      Refuse(
          fmt::format("{}: a name has no dot; write sections as objects: {{\"voting\": "
                      "{{\"max_candidates\": 8}}}}",
                      Excerpt(name)));
    }
    if (HasSection(name)) {
      return ReadSection(index, name);
    }
    for (Option& option : list_.options()) {
      if (option.name == name) {
        return ReadValue(index, &option);
      }
    }
    Refuse(fmt::format("{} is not an option; the nearest is {}", Excerpt(name), NearestName(name)));
  }

  void ReadValue(size_t index, Option* option) {
    const JsonValue& value = document_[index];
    if (auto* choice = std::get_if<NamedChoice>(&option->value)) {
      return Set(option->name, value, choice);
    }
    std::visit(
        [&](auto& target) {
          if constexpr (std::is_pointer_v<std::remove_reference_t<decltype(target)>>) {
            Set(option->name, value, target);
          }
        },
        option->value);
  }

  bool HasSection(const std::string& name) const {
    return !name.empty() &&
           std::any_of(list_.sections().begin(), list_.sections().end(),
                       [&](const OptionSection& section) { return section.name == name; });
  }

  std::string NearestName(const std::string& name) const {
    std::vector<std::string> known;
    for (const Option& option : list_.options()) {
      known.push_back(option.name);
    }
    for (const OptionSection& section : list_.sections()) {
      known.push_back(section.name);
    }
    std::erase(known, "");
    return *std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
      return Unlikeness(name, a) < Unlikeness(name, b);
    });
  }

  const JsonDocument& document_;
  OptionList& list_;
};

}  // namespace

void ReadOptions(std::string_view json, OptionList* list) {
  const JsonDocument document = ParseJson(json, kLimits);
  OptionsReader(document, list).ReadSection(0, "");
}

void ReadOptions(std::string_view json, CairnOptions* options) {
  CairnOptions read = *options;
  OptionList list = Describe(&read);
  ReadOptions(json, &list);
  read.Validate();
  *options = std::move(read);
}

void ReadOptionsFile(const std::string& path, CairnOptions* options) {
  const std::string json = ReadTextFile(path, kMaxOptionsBytes);
  try {
    ReadOptions(json, options);
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace cairn
