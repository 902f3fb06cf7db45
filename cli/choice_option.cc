#include "cli/choice_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "cli/options/nearest_name.h"
#include "core/printable.h"

namespace cairn {
namespace {

// What is wrong with a word; empty if it is one of `words`.
std::string Complaint(const std::string& word, const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), word) != words.end()) {
    return "";
  }
  return fmt::format("'{}' is not one of {}{}", Excerpt(word), fmt::join(words, ", "),
                     DidYouMean(word, words));
}

}  // namespace

CLI::Option* AddWordOption(CLI::App* command, const std::string& flag,
                           const std::vector<std::string>& words,
                           std::function<void(const std::string& word)> set,
                           const std::string& description) {
  const auto check = [words](const std::string& word) { return Complaint(word, words); };
  return command->add_option_function<std::string>(flag, std::move(set), description)
      ->check(CLI::Validator(check, ""))
      ->type_name(fmt::format("{}", fmt::join(words, "|")));
}

CLI::Option* AddChoiceOption(CLI::App* command, const std::string& flag, NamedChoice choice,
                             const std::string& description) {
  const std::string now = choice.Get();
  return AddWordOption(
             command, flag, choice.names(),
             [choice](const std::string& word) mutable { choice.Set(word); }, description)
      ->default_str(now);
}

}  // namespace cairn
