// Draws a plan of a simulated city.
#ifndef CAIRN_LAB_CITY_DRAW_CITY_H_
#define CAIRN_LAB_CITY_DRAW_CITY_H_

#include <string>

#include "lab/city/phone_queries.h"
#include "lab/city/simulated_mapping.h"

namespace cairn {

// Draws a north-up plan: houses colored by height, facade landmarks as dots, the passes of the
// mapping cars, and the positions and viewing directions of the phones. The extension selects PNG.
// The city must be small, because everything is drawn. Throws Error(kInvalidArgument) if the city
// has more than 1 km^2, and Error(kIo).
void DrawCity(const std::string& path, const SimulatedMapping& mapping,
              const PhoneQueries& queries);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_DRAW_CITY_H_
