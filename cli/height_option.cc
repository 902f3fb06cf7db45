#include "cli/height_option.h"

#include "cli/choice_option.h"

namespace cairn {

CLI::Option* AddHeightOption(CLI::App* command, std::optional<HeightReference>* height,
                             const std::string& help) {
  const std::string ellipsoid = HeightReferenceName(HeightReference::kEllipsoid);
  const std::string sea_level = HeightReferenceName(HeightReference::kMeanSeaLevel);
  return AddWordOption(
      command, "--height", {ellipsoid, sea_level},
      [height, ellipsoid](const std::string& word) {
        *height = word == ellipsoid ? HeightReference::kEllipsoid : HeightReference::kMeanSeaLevel;
      },
      help);
}

}  // namespace cairn
