// A drive of which every third frame is a map, and every third one a session.
#ifndef CAIRN_TESTS_INGEST_KITTI_THIRDS_H_
#define CAIRN_TESTS_INGEST_KITTI_THIRDS_H_

#include <filesystem>
#include <vector>

#include "ingest/colmap/colmap_reader.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn::testing {

// Needs the data set kitti_vo_2x51.
class KittiThirds {
 public:
  KittiThirds()
      : folder_(TestDataDir() / "kitti_vo_2x51"),
        positions_(ReadCameraPositions((folder_ / "georef_seq1.csv").string())),
        store_(MapStore::Create(temp_.File("map.gpkg"))) {
    const Reconstruction mapped = Third(0);
    ecef_from_world_ = Georegister(mapped, positions_, GeoregisterOptions()).ecef_from_world;
    IngestSession(mapped, ecef_from_world_, SessionNamed("map"), &store_, {});
  }

  // Every third frame from this one on.
  Reconstruction Third(size_t first) const {
    ColmapInput input{
        (folder_ / "colmap_model_seq1").string(), (folder_ / "database_seq1.db").string(), {}};
    for (size_t i = first; i < positions_.size(); i += 3) {
      input.image_names.push_back(positions_[i].image_name);
    }
    return ReadColmap(input);
  }

  const Geodetic& place() const { return positions_.front().position; }
  const Sim3d& ecef_from_world() const { return ecef_from_world_; }
  MapStore* store() { return &store_; }

 private:
  std::filesystem::path folder_;
  std::vector<CameraPosition> positions_;
  TempDir temp_;
  MapStore store_;
  Sim3d ecef_from_world_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_INGEST_KITTI_THIRDS_H_
