#include "lab/experiments/runs/cities.h"

#include "lab/experiments/runs/runs.h"

namespace cairn {

std::vector<std::pair<std::string, ExperimentWorldOptions>> Cities(
    const ExperimentContext& context) {
  std::vector<std::pair<std::string, ExperimentWorldOptions>> cities;
  for (const CityCharacter character : {CityCharacter::kOldTown, CityCharacter::kGrid,
                                        CityCharacter::kSuburb, CityCharacter::kHighRise}) {
    ExperimentWorldOptions options = StandardWorld(context);
    options.character = character;
    cities.emplace_back(CityCharacterName(character), options);
  }
  return cities;
}

}  // namespace cairn
