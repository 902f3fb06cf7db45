// How a photo was held: the side of its stored picture at which up is.
#ifndef CAIRN_INGEST_PLACE_PICTURE_UP_H_
#define CAIRN_INGEST_PLACE_PICTURE_UP_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// COLMAP and Cairn read stored pixels. A phone that is held upright stores its pictures lying, and
// says in the EXIF how to turn them.
enum class PictureUp {
  kTop,     // Pixels that need no turn.
  kLeft,    // A phone held upright (EXIF orientation 6); the x axis points to the ground.
  kRight,   // Orientation 8; the x axis points to the sky.
  kBottom,  // Orientation 3.
  kBack,    // A camera that looks straight down: up is behind it.
};

inline constexpr std::array<PictureUp, 5> kPictureUps = {
    PictureUp::kTop, PictureUp::kLeft, PictureUp::kRight, PictureUp::kBottom, PictureUp::kBack};

// Unit vector of up in a level camera that is held so (x right, y down, z forward).
inline Eigen::Vector3d UpInCam(PictureUp up) {
  switch (up) {
    case PictureUp::kTop:
      break;
    case PictureUp::kLeft:
      return -Eigen::Vector3d::UnitX();
    case PictureUp::kRight:
      return Eigen::Vector3d::UnitX();
    case PictureUp::kBottom:
      return Eigen::Vector3d::UnitY();
    case PictureUp::kBack:
      return -Eigen::Vector3d::UnitZ();
  }
  return -Eigen::Vector3d::UnitY();
}

// The image axis that stays horizontal however the camera pitches.
inline Eigen::Vector3d LevelInCam(PictureUp up) {
  const bool lies = up == PictureUp::kLeft || up == PictureUp::kRight;
  return lies ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
}

// From the EXIF orientation, 1 to 8; the mirrored ones count as their turns.
inline PictureUp FromExifOrientation(int orientation) {
  switch (orientation) {
    case 3:
    case 4:
      return PictureUp::kBottom;
    case 5:
    case 6:
      return PictureUp::kLeft;
    case 7:
    case 8:
      return PictureUp::kRight;
    default:
      return PictureUp::kTop;
  }
}

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_PICTURE_UP_H_
