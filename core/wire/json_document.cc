#include "core/wire/json_document.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/wire/json_error.h"

namespace cairn {
namespace {

constexpr size_t kOutOfRangeError =
    406;  // The library's id for a number outside the range of double.

// Handles the library's events. The library prescribes the names of the functions.
class DocumentBuilder {
 public:
  explicit DocumentBuilder(const JsonLimits& limits, size_t text_bytes)
      : limits_(limits), text_bytes_(text_bytes) {}

  JsonDocument Take() && { return std::move(values_); }

  bool null() {
    Add(JsonValue::Kind::kNull);
    return true;
  }
  bool boolean(bool value) {
    Add(JsonValue::Kind::kBool).number = value ? 1.0 : 0.0;
    return true;
  }
  bool number_integer(int64_t value) { return AddNumber(static_cast<double>(value)); }
  bool number_unsigned(uint64_t value) { return AddNumber(static_cast<double>(value)); }
  bool number_float(double value, const std::string&) { return AddNumber(value); }
  bool string(std::string& value) {
    Add(JsonValue::Kind::kString).text = std::move(value);
    return true;
  }
  bool binary(std::vector<uint8_t>&) { return false; }  // JSON text has no such event.
  bool start_object(size_t) { return Open(JsonValue::Kind::kObject); }
  bool end_object() { return Close(); }
  bool start_array(size_t) { return Open(JsonValue::Kind::kArray); }
  bool end_array() { return Close(); }

  bool key(std::string& name) {
    if (name.size() > limits_.max_name_bytes) {
      Refuse(fmt::format("a member's name is longer than {} bytes", limits_.max_name_bytes));
    }
    RefuseDuplicate(name);
    name_ = std::move(name);
    return true;
  }

  bool parse_error(size_t position, const std::string&, const nlohmann::json::exception& e) {
    // The library's message quotes the input, which may be long and may not be text.
    if (e.id == kOutOfRangeError) {
      Refuse("the JSON has a number that is out of range");
    }
    Refuse(fmt::format("the JSON does not parse at byte {} of {}", position, text_bytes_));
  }

 private:
  // An array or object whose end has not been read.
  struct OpenValue {
    size_t index = 0;
    size_t last_child = 0;
  };

  [[noreturn]] static void Refuse(const std::string& detail) {
    throw JsonError(detail, std::nullopt, "");
  }
  [[noreturn]] static void RefuseSize(const std::string& detail) {
    throw JsonError(
        detail, std::nullopt,
        "send features in their binary form, as base64 or as a part of a multipart body");
  }

  // Objects are small, so comparing every member is as fast as an index.
  void RefuseDuplicate(const std::string& name) const {
    const size_t parent = open_.back().index;
    if (values_[parent].num_children == 0) {
      return;
    }
    for (size_t i = parent + 1; i != 0; i = values_[i].next) {
      if (values_[i].name == name) {
        Refuse(fmt::format("an object has two members '{}'", name));
      }
    }
  }

  void CountChild() {
    OpenValue& open = open_.back();
    JsonValue& parent = values_[open.index];
    const bool is_array = parent.kind == JsonValue::Kind::kArray;
    const size_t max_children = is_array ? limits_.max_elements : limits_.max_members;
    if (parent.num_children >= max_children) {
      RefuseSize(is_array ? fmt::format("an array has more than {} elements", max_children)
                          : fmt::format("an object has more than {} members", max_children));
    }
    if (parent.num_children > 0) {
      values_[open.last_child].next = values_.size();
    }
    ++parent.num_children;
    open.last_child = values_.size();
  }

  JsonValue& Add(JsonValue::Kind kind) {
    if (values_.size() >= limits_.max_values) {
      RefuseSize(fmt::format("the JSON has more than {} values", limits_.max_values));
    }
    if (!open_.empty()) {
      CountChild();
    }
    JsonValue& value = values_.emplace_back();
    value.kind = kind;
    value.name = std::exchange(name_, {});
    return value;
  }

  bool AddNumber(double number) {
    Add(JsonValue::Kind::kNumber).number = number;
    return true;
  }

  bool Open(JsonValue::Kind kind) {
    if (open_.size() >= limits_.max_depth) {
      Refuse(fmt::format("the JSON is nested deeper than {}", limits_.max_depth));
    }
    Add(kind);
    open_.push_back({.index = values_.size() - 1});
    return true;
  }

  bool Close() {
    open_.pop_back();
    return true;
  }

  const JsonLimits& limits_;
  const size_t text_bytes_;
  JsonDocument values_;
  std::vector<OpenValue> open_;  // From the top level inwards.
  std::string name_;             // Name of the member whose value comes next.
};

}  // namespace

JsonDocument ParseJson(std::string_view text, const JsonLimits& limits) {
  DocumentBuilder builder(limits, text.size());
  nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  return std::move(builder).Take();
}

}  // namespace cairn
