// Options from a JSON file, of which nothing is trusted.
#ifndef CAIRN_CLI_OPTIONS_READ_OPTIONS_H_
#define CAIRN_CLI_OPTIONS_READ_OPTIONS_H_

#include <string>
#include <string_view>

#include "cli/options/cairn_options.h"

namespace cairn {

// Sets the options that `json` names; the others stay. The text is an object of options and of
// sections, which are objects themselves: {"voting": {"max_candidates": 8}}. Enumerators are given
// by name, an infinite number as "infinity". If it throws, `options` is unchanged:
// Error(kBadInput) if the text is no JSON, is nested too deep or has two members of one name;
// Error(kInvalidArgument), naming the option by its dotted name, if there is no such option, or if
// its value is of another type or makes no sense.
void ReadOptions(std::string_view json, CairnOptions* options);

// The same for what any list describes, of which some options may be set if it throws. Values that
// make no sense are for the caller to find.
void ReadOptions(std::string_view json, OptionList* list);

// The same with a file of at most 64 KiB, which the messages name; throws as ReadTextFile, too.
void ReadOptionsFile(const std::string& path, CairnOptions* options);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_READ_OPTIONS_H_
