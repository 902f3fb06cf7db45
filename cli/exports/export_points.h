// Writes the landmarks and keyframes of a map as a COLMAP model and as a PLY file.
#ifndef CAIRN_CLI_EXPORTS_EXPORT_POINTS_H_
#define CAIRN_CLI_EXPORTS_EXPORT_POINTS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "cli/exports/point_colors.h"
#include "core/rigid3.h"
#include "ingest/colmap/write_colmap.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ExportPointsOptions {
  std::string colmap_dir = {};  // An existing folder; empty: no model.
  ColmapModelFormat colmap_format = ColmapModelFormat::kBinary;
  std::string ply_path = {};  // Empty: no PLY file.
  PointColor color = PointColor::kSession;
  std::optional<SessionId> session = {};  // Only what this session has, or has seen.
  Sim3d world_from_ecef = {};             // Of the poses and points that are written.
  // Called with the tiles done and their number.
  std::function<void(int64_t done, int64_t total)> progress = {};
};

struct ExportedPoints {
  int64_t num_cameras = 0;
  int64_t num_images = 0;
  int64_t num_points = 0;        // Each landmark once.
  int64_t num_observations = 0;  // Of landmarks in keyframes.
  int64_t num_unseen = 0;        // Landmarks that no keyframe has any more; not in the model.
};

// The model has a camera for each set of intrinsics, an image for each keyframe and a point for
// each landmark that a keyframe still sees; ids of images and points are those of the map. Images
// of a map with several sessions are named `session/name`, or just `name` with options.session.
//
// A map does not keep where in its picture a keyframe saw a landmark. The keypoints of the model
// are therefore projections of the landmarks, whose error is zero by construction. ERROR of a point
// is what the map knows instead: the standard deviation of its position as it looks from its
// keyframes, in pixels, root mean square. Landmarks that do not project into a keyframe's picture
// are no observations.
//
// The PLY file is binary: x, y, z as doubles, red, green, blue, sigma_m and session (0: only by old
// sessions).
//
// Reads one tile after the other, and collects landmarks, which may be in several tiles, in unnamed
// files beside the output. Takes the memory of one tile, of the cameras, and of 1/64 of the map's
// landmarks, but at least of a million. Throws Error(kIo), Error(kMapDamaged), and Error(kBadInput)
// if ids of keyframes exceed COLMAP's 32 bits or COLMAP's models cannot hold the name of a keyframe
// (ingest/colmap/colmap_model_writer.h).
ExportedPoints ExportPoints(const MapSnapshot& map, const ExportPointsOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_EXPORTS_EXPORT_POINTS_H_
