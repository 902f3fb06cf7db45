// The way in which each camera of a reconstruction was held. Private to ingest/place.
#ifndef CAIRN_INGEST_PLACE_LEVEL_CAMERAS_H_
#define CAIRN_INGEST_PLACE_LEVEL_CAMERAS_H_

#include <Eigen/Core>
#include <vector>

#include "core/scene/reconstruction.h"
#include "ingest/place/georegister.h"
#include "ingest/place/picture_up.h"
#include "ingest/place/similarity_problem.h"

namespace cairn {

struct CameraHolds {
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitZ();
  std::vector<PictureUp> of_image;
  UpReport report;
};

// Throws Error(kBadInput), with what to do, if two ways are about as likely, if the positions fit
// the mirror image of the reconstruction and not the reconstruction, or if options.up asks for
// orientations that no photo has. A way that options.up states is not doubted;
// the report says if all else speaks against it. The centers of the
// positions are those of the reconstruction times `normalized_per_world`, and moved.
CameraHolds FindCameraHolds(const Reconstruction& reconstruction,
                            const ImageOrientations& orientations,
                            const std::vector<SimilarityProblem::Position>& positions,
                            double normalized_per_world, const GeoregisterOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_LEVEL_CAMERAS_H_
