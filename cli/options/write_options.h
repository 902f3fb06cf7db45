// Options as a file that ReadOptions takes, and as the page docs/options.md.
#ifndef CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_
#define CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_

#include <string>

#include "cli/options/cairn_options.h"

namespace cairn {

// Returns all options as JSON, in sections. Ends with a line feed.
std::string OptionsAsJson(const CairnOptions& options);

// Returns the page: one table for each section, with the values of `options` as the defaults.
std::string OptionsAsMarkdown(const CairnOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_WRITE_OPTIONS_H_
