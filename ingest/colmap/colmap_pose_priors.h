// Reads what a COLMAP database knows about an image before reconstruction: position and gravity.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_POSE_PRIORS_H_
#define CAIRN_INGEST_COLMAP_COLMAP_POSE_PRIORS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/geodesy.h"

namespace cairn {

namespace sqlite {
class Connection;
}

struct ColmapPosePrior {
  // The height is the EXIF altitude of the photo, hence above mean sea level; 0 if none is stored.
  std::optional<Geodetic> gps;
  std::optional<double> gps_accuracy_m;        // 68 % radius; only together with `gps`.
  std::optional<Eigen::Vector3d> down_in_cam;  // Unit vector.
};

// The priors by the names of the images. Images without any prior are missing.
//
// COLMAP up to 3.9 has the position in `images.prior_t*`. COLMAP 3.10 and later have the table
// `pose_priors`: one row an image until 3.12, then one row a datum of a sensor, and since 4.0 with
// gravity. A newer COLMAP that opens a database of 3.9 adds an empty table and leaves the columns,
// so the columns count for images whose position the table lacks.
//
// Positions count if they are WGS84 and not (0, 0), which COLMAP writes for photos without GPS. NaN
// and NULL mean that a value is unknown. The accuracy comes from the horizontal part of the
// covariance, which is in square meters. COLMAP's gravity points down in the camera frame. Logs a
// warning for `path` if positions have another coordinate system, or are no latitude and longitude
// in degrees; these do not count.
std::unordered_map<std::string, ColmapPosePrior> ReadColmapPosePriors(
    const std::string& path, sqlite::Connection* connection);

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_POSE_PRIORS_H_
