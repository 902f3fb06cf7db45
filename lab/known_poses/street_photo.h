// A photograph and where it was taken.
#ifndef CAIRN_LAB_KNOWN_POSES_STREET_PHOTO_H_
#define CAIRN_LAB_KNOWN_POSES_STREET_PHOTO_H_

#include <optional>
#include <string>

#include "core/geodesy.h"
#include "core/rigid3.h"
#include "ingest/images/gray_image.h"

namespace cairn {

struct StreetPhoto {
  std::string name;
  Rigid3d cam_from_enu;         // The truth; enu at the origin of the scene.
  std::optional<Geodetic> gps;  // What the camera's receiver says.
  GrayImage image;
};

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_STREET_PHOTO_H_
