// A photo and the place where it was taken.
#ifndef CAIRN_CLI_DEMO_STREET_STREET_PHOTO_H_
#define CAIRN_CLI_DEMO_STREET_STREET_PHOTO_H_

#include <optional>
#include <string>

#include "core/geodesy.h"
#include "core/images/gray_image.h"
#include "core/rigid3.h"

namespace cairn {

struct StreetPhoto {
  std::string name;
  Rigid3d cam_from_enu;         // True pose; enu is at the scene's origin.
  std::optional<Geodetic> gps;  // Position reported by the camera's receiver.
  GrayImage image;
};

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_STREET_PHOTO_H_
