#include "cli/height_option.h"

#include <CLI/CLI.hpp>
#include <map>

namespace cairn {

CLI::Option* AddHeightOption(CLI::App* command, std::optional<HeightReference>* height,
                             const std::string& help) {
  static const std::map<std::string, HeightReference> kReferences = {
      {HeightReferenceName(HeightReference::kEllipsoid), HeightReference::kEllipsoid},
      {HeightReferenceName(HeightReference::kMeanSeaLevel), HeightReference::kMeanSeaLevel}};
  return command->add_option("--height", *height, help)
      ->transform(CLI::CheckedTransformer(kReferences).description(""))
      ->type_name("ellipsoid|msl");
}

}  // namespace cairn
