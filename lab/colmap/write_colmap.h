// Writes reconstructions the way COLMAP does: for tests of the reader, and for other tools.
#ifndef CAIRN_LAB_COLMAP_WRITE_COLMAP_H_
#define CAIRN_LAB_COLMAP_WRITE_COLMAP_H_

#include <string>

#include "ingest/sfm/reconstruction.h"

namespace cairn {

enum class ColmapModelFormat { kBinary, kText };

// cameras, images and points3D in the folder `dir`, which must exist. COLMAP's ids are the indices
// plus a constant that differs between cameras, images and points. Throws Error(kIo).
void WriteColmapModel(const Reconstruction& reconstruction, const std::string& dir,
                      ColmapModelFormat format);

// Where the images' GPS positions go, by version of COLMAP.
enum class ColmapGpsTable {
  kNone,
  kImageColumns,        // images.prior_t*, until 3.9.
  kPosePriorsOfImages,  // pose_priors by image, 3.10 and 3.11.
  kPosePriorsOfData,    // pose_priors by data id, since 3.12.
};

struct ColmapDatabaseOptions {
  int keypoint_columns = 6;  // 2 (place), 4 (and scale, orientation) or 6 (and affine shape).
  ColmapGpsTable gps = ColmapGpsTable::kImageColumns;
};

// A database with cameras, images, keypoints and byte descriptors (L1 root SIFT, COLMAP's default),
// and with empty tables of matches. `path` must not exist. Throws Error(kIo).
void WriteColmapDatabase(const Reconstruction& reconstruction, const std::string& path,
                         const ColmapDatabaseOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_COLMAP_WRITE_COLMAP_H_
