// What to say about a command line that cannot be parsed.
#ifndef CAIRN_CLI_USAGE_MESSAGE_H_
#define CAIRN_CLI_USAGE_MESSAGE_H_

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace cairn {

// Describes the fault, names the verb or option that was probably meant, and refers to the help.
// `app` has just thrown `error` at the words argv[1], ...
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv);

// The verb below `app` that the words name, such as {"keys", "new"}; `app` itself without words.
// Throws Error(kInvalidArgument), which names the nearest verb.
const CLI::App& FindVerb(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace cairn

#endif  // CAIRN_CLI_USAGE_MESSAGE_H_
