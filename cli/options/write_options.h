// Options as a file that ReadOptions takes, and as the page docs/options.md.
#ifndef CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_
#define CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_

#include <string>

#include "cli/options/cairn_options.h"

namespace cairn {

// Every option, in sections; ends with a line feed.
std::string OptionsAsJson(const CairnOptions& options);

// The page: a table a section, with the values of `options` as the defaults.
std::string OptionsAsMarkdown(const CairnOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_
