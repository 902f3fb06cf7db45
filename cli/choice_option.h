// Flags that take the name of an enumerator.
#ifndef CAIRN_CLI_CHOICE_OPTION_H_
#define CAIRN_CLI_CHOICE_OPTION_H_

#include <string>

#include "cli/options/option_list.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

// Adds a flag that sets `choice`, whose value is the default.
void AddChoiceOption(CLI::App* command, const std::string& flag, NamedChoice choice,
                     const std::string& description);

}  // namespace cairn

#endif  // CAIRN_CLI_CHOICE_OPTION_H_
