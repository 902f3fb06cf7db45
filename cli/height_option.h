// The option --height of verbs that take heights.
#ifndef CAIRN_CLI_HEIGHT_OPTION_H_
#define CAIRN_CLI_HEIGHT_OPTION_H_

#include <optional>
#include <string>

#include "core/geoid.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cairn {

// Adds --height ellipsoid|msl.
CLI::Option* AddHeightOption(CLI::App* command, std::optional<HeightReference>* height,
                             const std::string& help);

}  // namespace cairn

#endif  // CAIRN_CLI_HEIGHT_OPTION_H_
