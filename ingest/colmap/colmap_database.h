// Reads keypoint shapes, descriptors and priors of poses from a COLMAP database.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_DATABASE_H_
#define CAIRN_INGEST_COLMAP_COLMAP_DATABASE_H_

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/packed_features.h"
#include "ingest/colmap/colmap_descriptors.h"
#include "ingest/colmap/colmap_pose_priors.h"

namespace cairn {

namespace sqlite {
class Connection;
enum class Access;
}  // namespace sqlite

// An open database. Use from one thread at a time. Every function throws Error(kBadInput), which
// names the file and the image (if there is one), if the tables are not COLMAP's or hold invalid
// values.
class ColmapDatabase {
 public:
  // Opens the file as immutable if it cannot be opened otherwise and has no log, as on a disk that
  // cannot be written to. Also throws Error(kNotFound), and Error(kIo) if it cannot be read.
  explicit ColmapDatabase(const std::string& path);
  ~ColmapDatabase();

  bool HasImage(const std::string& image_name);
  std::vector<std::string> ImageNames();  // In the order of their ids.

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
  PackedFeatures ReadFeatures(const std::string& image_name);

  // What ReadColmapPosePriors reads for the image.
  ColmapPosePrior ReadPosePrior(const std::string& image_name);

 private:
  void Open();
  // Takes back the changes that a killed program left in a journal, as each program does that opens
  // the database to write. Returns false if there is no journal, or nobody may write here.
  bool RollBack();
  void OpenAs(sqlite::Access access);
  SiftNormalization NormalizationOfAll();
  PackedDescriptors ReadDescriptors(const std::string& image_name);

  std::string path_;
  std::unique_ptr<sqlite::Connection> connection_;
  bool has_descriptor_type_ = false;
  std::optional<SiftNormalization> normalization_;  // Empty until it has been determined.
  // Empty until the first call of ReadPosePrior, which reads all.
  std::optional<std::unordered_map<std::string, ColmapPosePrior>> pose_priors_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_DATABASE_H_
