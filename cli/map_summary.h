// What `cairn map` prints about the photos.
#ifndef CAIRN_CLI_MAP_SUMMARY_H_
#define CAIRN_CLI_MAP_SUMMARY_H_

#include <nlohmann/json_fwd.hpp>

#include "mapping/session/map_photos.h"

namespace cairn {

void PrintMappedPhotos(const MappedPhotos& mapped);
nlohmann::ordered_json MappedPhotosJson(const MappedPhotos& mapped);

}  // namespace cairn

#endif  // CAIRN_CLI_MAP_SUMMARY_H_
