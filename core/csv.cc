#include "core/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/utf16.h"

namespace cairn {
namespace {

// Returns the separator of the text whose first line this is.
char SeparatorOf(std::string_view line) {
  bool in_quotes = false;
  char separator = 0;
  for (const char letter : line) {
    in_quotes = letter == '"' ? !in_quotes : in_quotes;
    if (in_quotes) {
      continue;
    }
    if (letter == ',') {
      return ',';
    }
    if (separator == 0 && (letter == ';' || letter == '\t')) {
      separator = letter;
    }
  }
  return separator == 0 ? ',' : separator;
}

}  // namespace

std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char letter : text) {
    quoted += letter == '"' ? "\"\"" : std::string(1, letter);
  }
  return quoted + '"';
}

std::string CsvNumber(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

CsvReader::CsvReader(std::string_view text) : rest_(text) {
  if (IsUtf16(text)) {
    throw Error(ErrorCode::kBadInput, "the text is UTF-16; save it as UTF-8");
  }
  const size_t begin = std::min(text.find_first_not_of("\r\n"), text.size());
  separator_ = SeparatorOf(text.substr(begin, text.find_first_of("\r\n", begin) - begin));
  TakeStatedSeparator();
}

void CsvReader::TakeStatedSeparator() {
  constexpr std::string_view kWord = "sep=";
  const size_t size = std::min(rest_.find_first_of("\r\n"), rest_.size());
  if (size == kWord.size() + 1 && rest_.starts_with(kWord)) {
    separator_ = rest_[kWord.size()];
    rest_.remove_prefix(size);
    SkipEndOfLine();
  }
}

std::optional<double> CsvReader::NumberOf(std::string text) const {
  if (separator_ != ',') {
    std::replace(text.begin(), text.end(), ',', '.');
  }
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* const end = text.data() + text.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(begin, end, value);
  return error == std::errc() && rest == end ? std::optional(value) : std::nullopt;
}

bool CsvReader::AtEndOfLine() const {
  return rest_.empty() || rest_.front() == '\n' || rest_.front() == '\r';
}

void CsvReader::SkipBlanks() {
  while (!rest_.empty() && rest_.front() != separator_ &&
         (rest_.front() == ' ' || rest_.front() == '\t')) {
    rest_.remove_prefix(1);
  }
}

void CsvReader::SkipEndOfLine() {
  if (!rest_.empty()) {
    rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : 1);
    ++line_;
  }
}

std::string CsvReader::QuotedCell() {
  rest_.remove_prefix(1);
  std::string cell;
  while (true) {
    const size_t quote = rest_.find('"');
    if (quote == std::string_view::npos) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("line {}: a quoted cell does not end", first_line_));
    }
    cell += rest_.substr(0, quote);
    rest_.remove_prefix(quote + 1);
    if (!rest_.starts_with('"')) {
      break;
    }
    cell += '"';
    rest_.remove_prefix(1);
  }
  line_ += std::count(cell.begin(), cell.end(), '\n');
  SkipBlanks();
  if (!AtEndOfLine() && rest_.front() != separator_) {
    throw Error(ErrorCode::kBadInput, fmt::format("line {}: text follows a quoted cell", line_));
  }
  return cell;
}

std::string CsvReader::PlainCell() {
  const char ends[] = {separator_, '\r', '\n'};
  const size_t size = std::min(rest_.find_first_of({ends, sizeof(ends)}), rest_.size());
  const std::string_view cell = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return std::string(cell.substr(0, cell.find_last_not_of(" \t") + 1));
}

bool CsvReader::Next() {
  while (SkipBlanks(), !rest_.empty() && AtEndOfLine()) {
    SkipEndOfLine();
  }
  if (rest_.empty()) {
    return false;
  }
  first_line_ = line_;
  cells_.clear();
  while (true) {
    SkipBlanks();
    cells_.push_back(rest_.starts_with('"') ? QuotedCell() : PlainCell());
    if (AtEndOfLine()) {
      SkipEndOfLine();
      return true;
    }
    rest_.remove_prefix(1);  // The separator.
  }
}

}  // namespace cairn
