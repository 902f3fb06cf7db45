// Flags that take one of several words.
#ifndef CAIRN_CLI_CHOICE_OPTION_H_
#define CAIRN_CLI_CHOICE_OPTION_H_

#include <functional>
#include <string>
#include <vector>

#include "cli/options/option_list.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cairn {

// Adds a flag that takes one of `words`. The help lists them, and so does the error about any other
// word, which names the nearest, too. `set` gets the word.
CLI::Option* AddWordOption(CLI::App* command, const std::string& flag,
                           const std::vector<std::string>& words,
                           std::function<void(const std::string& word)> set,
                           const std::string& description);

// The same for an enumerator: sets `choice`.
CLI::Option* AddChoiceOption(CLI::App* command, const std::string& flag, NamedChoice choice,
                             const std::string& description);

}  // namespace cairn

#endif  // CAIRN_CLI_CHOICE_OPTION_H_
