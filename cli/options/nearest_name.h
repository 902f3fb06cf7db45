// Finds the name that somebody meant who wrote another one.
#ifndef CAIRN_CLI_OPTIONS_NEAREST_NAME_H_
#define CAIRN_CLI_OPTIONS_NEAREST_NAME_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Insertions, deletions and replacements of a letter, and exchanges of two neighbors, that turn `a`
// into `b` (optimal string alignment).
size_t EditDistance(std::string_view a, std::string_view b);

// "; did you mean 'check'?", or nothing if no name resembles the word. A name resembles a word if
// one of them begins with the other, or if at most a third of the letters differ.
std::string DidYouMean(std::string_view word, const std::vector<std::string>& names);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_NEAREST_NAME_H_
