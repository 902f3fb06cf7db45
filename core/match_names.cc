#include "core/match_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_map>

#include "core/canonical_text.h"
#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

// Folders are separated by single slashes; there is no "./" in front.
std::string PathKey(const std::string& name) {
  std::string key = CanonicalText(name);
  std::replace(key.begin(), key.end(), '\\', '/');
  key.erase(
      std::unique(key.begin(), key.end(), [](char a, char b) { return a == '/' && b == '/'; }),
      key.end());
  while (key.starts_with("./")) {
    key.erase(0, 2);
  }
  return key;
}

bool IsLetter(char c) { return c >= 'a' && c <= 'z'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// The key without an ending, as .jpg or .cr2. The numbers of IMG_2026.11 and the names of hidden
// files are no endings.
std::string StemKey(std::string key) {
  constexpr size_t kMinLetters = 2, kMaxLetters = 4;
  const size_t dot = key.rfind('.');
  if (dot == key.npos || dot == 0 || key[dot - 1] == '/') {
    return key;
  }
  const std::string_view ending = std::string_view(key).substr(dot + 1);
  const bool is_ending =
      ending.size() >= kMinLetters && ending.size() <= kMaxLetters &&
      std::any_of(ending.begin(), ending.end(), IsLetter) &&
      std::all_of(ending.begin(), ending.end(), [](char c) { return IsLetter(c) || IsDigit(c); });
  key.resize(is_ending ? dot : key.size());
  return key;
}

// The names of a list that match nothing yet, by key.
struct Unmatched {
  std::vector<int> idx;
  std::vector<std::string> keys;
};

class NameMatcher {
 public:
  NameMatcher(const std::vector<std::string>& wanted, const std::vector<std::string>& known)
      : wanted_(wanted), known_(known), wanted_of_known_(known.size(), -1) {
    matches_.known_of_wanted.assign(wanted.size(), -1);
  }

  NameMatches Match() {
    MatchEqual();
    MatchKeys(PathKey);
    if (IsWithoutMatches()) {
      MatchPathEnds(PathKey);
    }
    const KeyFunction stem_key = [](const std::string& name) { return StemKey(PathKey(name)); };
    if (IsWithoutMatches()) {
      MatchKeys(stem_key);
    }
    if (IsWithoutMatches()) {
      MatchPathEnds(stem_key);
    }
    return matches_;
  }

 private:
  using KeyFunction = std::string (*)(const std::string& name);

  bool IsWithoutMatches() const {
    return std::all_of(matches_.known_of_wanted.begin(), matches_.known_of_wanted.end(),
                       [](int known_idx) { return known_idx < 0; });
  }

  void MatchEqual() {
    std::unordered_map<std::string_view, int> idx_of_known;
    for (size_t i = 0; i < known_.size(); ++i) {
      idx_of_known.emplace(known_[i], static_cast<int>(i));
    }
    for (size_t i = 0; i < wanted_.size(); ++i) {
      if (const auto found = idx_of_known.find(wanted_[i]); found != idx_of_known.end()) {
        matches_.known_of_wanted[i] = found->second;
        wanted_of_known_[found->second] = static_cast<int>(i);
      }
    }
  }

  static Unmatched Rest(const std::vector<std::string>& names, const std::vector<int>& partners,
                        KeyFunction key) {
    Unmatched rest;
    for (size_t i = 0; i < names.size(); ++i) {
      if (partners[i] < 0) {
        rest.idx.push_back(static_cast<int>(i));
        rest.keys.push_back(key(names[i]));
      }
    }
    return rest;
  }

  // Matches a pair that is not equal. Refuses a second partner.
  void Pair(int wanted_idx, int known_idx) {
    int& known_of_wanted = matches_.known_of_wanted[wanted_idx];
    int& wanted_of_known = wanted_of_known_[known_idx];
    if (known_of_wanted >= 0 && known_[known_of_wanted] != known_[known_idx]) {
      RefuseAmbiguous(wanted_[wanted_idx], known_[known_of_wanted], known_[known_idx]);
    }
    if (wanted_of_known >= 0 && wanted_[wanted_of_known] != wanted_[wanted_idx]) {
      RefuseAmbiguous(known_[known_idx], wanted_[wanted_of_known], wanted_[wanted_idx]);
    }
    matches_.num_inexact += known_of_wanted < 0 ? 1 : 0;
    matches_.inexact_example = wanted_idx;
    known_of_wanted = known_idx;
    wanted_of_known = wanted_idx;
  }

  [[noreturn]] static void RefuseAmbiguous(const std::string& name, const std::string& one,
                                           const std::string& other) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the photo '{}' could be '{}' or '{}'; write its name as it is in the "
                            "other file",
                            Excerpt(name), Excerpt(one), Excerpt(other)));
  }

  void MatchKeys(KeyFunction key) {
    const Unmatched known = Rest(known_, wanted_of_known_, key);
    const Unmatched wanted = Rest(wanted_, matches_.known_of_wanted, key);
    std::unordered_multimap<std::string_view, int> idx_of_key;
    for (size_t i = 0; i < known.idx.size(); ++i) {
      idx_of_key.emplace(known.keys[i], known.idx[i]);
    }
    for (size_t i = 0; i < wanted.idx.size(); ++i) {
      const auto [begin, end] = idx_of_key.equal_range(wanted.keys[i]);
      for (auto it = begin; it != end; ++it) {
        Pair(wanted.idx[i], it->second);
      }
    }
  }

  void MatchPathEnds(KeyFunction key) {
    const Unmatched known = Rest(known_, wanted_of_known_, key);
    const Unmatched wanted = Rest(wanted_, matches_.known_of_wanted, key);
    PairWithEnds(wanted, known,
                 [&](int wanted_idx, int known_idx) { Pair(wanted_idx, known_idx); });
    PairWithEnds(known, wanted,
                 [&](int known_idx, int wanted_idx) { Pair(wanted_idx, known_idx); });
  }

  // Calls `pair` for each short name that is the end of a long one.
  template <typename PairFunction>
  static void PairWithEnds(const Unmatched& short_names, const Unmatched& long_names,
                           const PairFunction& pair) {
    std::unordered_map<std::string_view, int> idx_of_key;
    for (size_t i = 0; i < short_names.idx.size(); ++i) {
      idx_of_key.emplace(short_names.keys[i], short_names.idx[i]);
    }
    for (size_t i = 0; i < long_names.idx.size(); ++i) {
      const std::string_view key = long_names.keys[i];
      for (size_t slash = key.find('/'); slash != key.npos; slash = key.find('/', slash + 1)) {
        if (const auto found = idx_of_key.find(key.substr(slash + 1)); found != idx_of_key.end()) {
          pair(found->second, long_names.idx[i]);
        }
      }
    }
  }

  const std::vector<std::string>& wanted_;
  const std::vector<std::string>& known_;
  NameMatches matches_;
  std::vector<int> wanted_of_known_;
};

}  // namespace

NameMatches MatchNames(const std::vector<std::string>& wanted,
                       const std::vector<std::string>& known) {
  return NameMatcher(wanted, known).Match();
}

std::string InexactExample(const NameMatches& matches, const std::vector<std::string>& wanted,
                           const std::vector<std::string>& known) {
  const int wanted_idx = matches.inexact_example;
  return fmt::format("'{}' as '{}'", Excerpt(wanted[wanted_idx]),
                     Excerpt(known[matches.known_of_wanted[wanted_idx]]));
}

std::string ExampleNames(const std::vector<std::string>& names) {
  constexpr size_t kMaxExamples = 3;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMaxExamples); ++i) {
    text += fmt::format("{}'{}'", i == 0 ? "" : ", ", Excerpt(names[i]));
  }
  if (names.size() > kMaxExamples) {
    text += fmt::format(" and {} others", names.size() - kMaxExamples);
  }
  return text.empty() ? "none" : text;
}

}  // namespace cairn
