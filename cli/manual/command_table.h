// The verbs of a program and their options as plain data, for all that is made of them beside
// --help: man pages, completion, suggestions.
#ifndef CAIRN_CLI_MANUAL_COMMAND_TABLE_H_
#define CAIRN_CLI_MANUAL_COMMAND_TABLE_H_

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

// An option, a flag or a positional argument.
struct ArgumentRow {
  std::vector<std::string> names;  // "-h", "--help"; of a positional "MAP".
  std::string value;               // "FILE", "auto|map|positions"; empty for a flag.
  std::string default_value;       // Empty if there is none to tell.
  std::string meaning;
  std::vector<std::string> needs;  // Names of options without which it is refused.
  bool is_positional = false;
  bool is_required = false;
  bool is_repeated = false;
  std::vector<std::string> words;  // What the value may be, if `value` lists words.
  bool takes_file = false;         // The value may name a file or a folder.
};

struct CommandTable {
  std::string name;     // "cairn", "localize", "new".
  std::string meaning;  // One sentence.
  std::string footer;   // Notes and examples, as --help prints them.
  std::vector<ArgumentRow> arguments;
  std::vector<CommandTable> commands;  // Without the hidden ones.
};

// Reads what was added to `app`: the table has what --help has.
CommandTable TableOf(const CLI::App& app);

}  // namespace cairn

#endif  // CAIRN_CLI_MANUAL_COMMAND_TABLE_H_
