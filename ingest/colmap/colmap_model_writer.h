// Writes a COLMAP model piece by piece, with little memory.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_MODEL_WRITER_H_
#define CAIRN_INGEST_COLMAP_COLMAP_MODEL_WRITER_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "core/camera.h"
#include "core/replace_file.h"
#include "core/rigid3.h"
#include "ingest/colmap/write_colmap.h"

namespace cairn {

struct ColmapKeypoint {
  static constexpr int64_t kNoPoint = -1;

  double x_px = 0.0, y_px = 0.0;
  int64_t point_id = kNoPoint;
};

struct ColmapTrackElement {
  uint32_t image_id = 0;
  uint32_t keypoint_idx = 0;
};

// The files cameras, images and points3D of a folder that exists, with the extension .bin or .txt.
// Their objects may come in any order. COLMAP 3.8 and later read them. All functions throw
// Error(kIo). Use from one thread.
class ColmapModelWriter {
 public:
  ColmapModelWriter(const std::string& dir, ColmapModelFormat format);

  void AddCamera(uint32_t id, const Camera& camera);
  // Throws Error(kBadInput) if the name has a line break or a zero byte, which the files cannot
  // hold.
  void AddImage(uint32_t id, const std::string& name, uint32_t camera_id,
                const Rigid3d& cam_from_world, std::span<const ColmapKeypoint> keypoints);
  void AddPoint(uint64_t id, const Eigen::Vector3d& x_in_world, const std::array<uint8_t, 3>& rgb,
                double error_px, std::span<const ColmapTrackElement> track);

  // Gives the files their names. Without it, the destructor leaves the folder as it was.
  void Commit();

 private:
  struct File {
    FileReplacement file;
    uint64_t num_records = 0;
  };
  bool is_binary() const { return format_ == ColmapModelFormat::kBinary; }

  ColmapModelFormat format_;
  File cameras_, images_, points_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_MODEL_WRITER_H_
