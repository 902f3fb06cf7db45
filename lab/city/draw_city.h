// A plan of a simulated city.
#ifndef CAIRN_LAB_CITY_DRAW_CITY_H_
#define CAIRN_LAB_CITY_DRAW_CITY_H_

#include <string>

#include "lab/city/cameras/phone_queries.h"
#include "lab/city/cameras/simulated_mapping.h"

namespace cairn {

// North-up: houses coloured by height, facade landmarks as dots, the passes of the mapping cars,
// and where the phones stand and look. PNG by extension. The city has to be small: everything is
// drawn. Throws Error(kInvalidArgument) if it has more than 1 km^2, Error(kIo).
void DrawCity(const std::string& path, const SimulatedMapping& mapping,
              const PhoneQueries& queries);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_DRAW_CITY_H_
