// What ingest needs of a COLMAP database: keypoint shapes, descriptors and GPS priors.
#ifndef CAIRN_INGEST_READERS_COLMAP_DATABASE_H_
#define CAIRN_INGEST_READERS_COLMAP_DATABASE_H_

#include <memory>
#include <optional>
#include <string>

#include "core/features.h"
#include "core/geodesy.h"
#include "ingest/readers/colmap_descriptors.h"

namespace cairn {

namespace sqlite {
class Connection;
}

// An open database. One thread at a time. Every function throws Error(kBadInput) that names the
// file, and the image where there is one, if the tables are not COLMAP's or hold what they should
// not.
class ColmapDatabase {
 public:
  // Also throws Error(kNotFound).
  explicit ColmapDatabase(const std::string& path);
  ~ColmapDatabase();

  bool HasImage(const std::string& image_name);

  // Keypoints with 2, 4 (scale, orientation) or 6 (affine shape) columns and SIFT as bytes. Other
  // descriptors (ALIKED, floats, another dimension) are refused with their name.
  //
  // COLMAP stores round(512 * sqrt(s)), s the L1-normalised SIFT descriptor (its default, L1_ROOT:
  // against OpenCV's SIFT of the same images, descriptors read this way lie 0.07 apart in the
  // median and 0.34 if they are taken as L2-normalised). Returned is 512 * s, so that RootSIFT
  // normalisation gives back sqrt(s) here and the same for SIFT from elsewhere. A database with
  // the normalisation L2, which SiftStatistics tells, is returned as it is stored.
  FeatureSet ReadFeatures(const std::string& image_name);

  // From `images.prior_t*` (COLMAP up to 3.9) or the table `pose_priors` (since 3.10; only WGS84);
  // nothing if there is none or it is (0, 0), which COLMAP writes for photos without GPS. The
  // height is the photo's EXIF altitude, hence above mean sea level.
  std::optional<Geodetic> ReadGps(const std::string& image_name);

 private:
  SiftNormalization NormalizationOfAll();
  DescriptorMatrix ReadDescriptors(const std::string& image_name);

  std::string path_;
  std::unique_ptr<sqlite::Connection> connection_;
  std::string gps_sql_;  // Empty if the database has no priors.
  bool has_descriptor_type_ = false;
  std::optional<SiftNormalization> normalization_;  // Once it is known.
};

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_COLMAP_DATABASE_H_
