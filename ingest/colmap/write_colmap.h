// Writes reconstructions in COLMAP's formats, for tests of the reader and for other tools.
#ifndef CAIRN_INGEST_COLMAP_WRITE_COLMAP_H_
#define CAIRN_INGEST_COLMAP_WRITE_COLMAP_H_

#include <string>

#include "core/scene/reconstruction.h"

namespace cairn {

enum class ColmapModelFormat { kBinary, kText };

// Writes cameras, images and points3D to the folder `dir`, which must exist. COLMAP's ids are the
// indices plus a constant that differs between cameras, images and points. Throws Error(kIo), and
// Error(kBadInput) if the name of an image has a line break or a zero byte.
void WriteColmapModel(const Reconstruction& reconstruction, const std::string& dir,
                      ColmapModelFormat format);

// The place of the images' GPS positions, which depends on COLMAP's version. Only the last place
// has room for their accuracy and for gravity.
enum class ColmapGpsTable {
  kNone,
  kImageColumns,        // images.prior_t*, until 3.9.
  kPosePriorsOfImages,  // pose_priors by image, 3.10 and 3.11.
  kPosePriorsOfData,    // pose_priors by data id, since 3.12.
  // pose_priors by data id with covariance and gravity, and descriptors with a type, since 4.0.
  kPosePriorsWithGravity,
};

struct ColmapDatabaseOptions {
  // 2 (position), 4 (plus scale and orientation) or 6 (plus affine shape).
  int keypoint_columns = 6;
  ColmapGpsTable gps = ColmapGpsTable::kImageColumns;
};

// Writes a database with cameras, images, keypoints, byte descriptors (L1 root SIFT, COLMAP's
// default) and empty tables of matches. `path` must not exist. Throws Error(kIo).
void WriteColmapDatabase(const Reconstruction& reconstruction, const std::string& path,
                         const ColmapDatabaseOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_WRITE_COLMAP_H_
