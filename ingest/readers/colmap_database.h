// Reads keypoint shapes, descriptors and GPS priors from a COLMAP database.
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

// An open database. Use from one thread at a time. Every function throws Error(kBadInput), which
// names the file and the image (if there is one), if the tables are not COLMAP's or hold invalid
// values.
class ColmapDatabase {
 public:
  // Also throws Error(kNotFound).
  explicit ColmapDatabase(const std::string& path);
  ~ColmapDatabase();

  bool HasImage(const std::string& image_name);

  // Reads keypoints with 2, 4 (scale, orientation) or 6 (affine shape) columns, and SIFT
  // descriptors as bytes. Refuses other descriptors (ALIKED, floats, another dimension) and names
  // them.
  //
  // COLMAP by default (L1_ROOT) stores round(512 * sqrt(s)), where s is the L1-normalized SIFT
  // descriptor. This was checked against OpenCV's SIFT of the same images: the median distance
  // between descriptors is 0.07 if they are read this way, and 0.34 if they are taken as
  // L2-normalized. The function returns 512 * s. RootSIFT normalization then gives sqrt(s), the
  // same as for SIFT from other sources. Descriptors with the normalization L2, which
  // SiftStatistics detects, are returned as stored.
  FeatureSet ReadFeatures(const std::string& image_name);

  // Reads `images.prior_t*` (COLMAP up to 3.9) or the table `pose_priors` (since 3.10; only WGS84).
  // Returns nothing if there is no prior or if the prior is (0, 0), which COLMAP writes for photos
  // without GPS. The height is the EXIF altitude of the photo, hence above mean sea level.
  std::optional<Geodetic> ReadGps(const std::string& image_name);

 private:
  SiftNormalization NormalizationOfAll();
  DescriptorMatrix ReadDescriptors(const std::string& image_name);

  std::string path_;
  std::unique_ptr<sqlite::Connection> connection_;
  std::string gps_sql_;  // Empty if the database has no priors.
  bool has_descriptor_type_ = false;
  std::optional<SiftNormalization> normalization_;  // Empty until it has been determined.
};

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_COLMAP_DATABASE_H_
