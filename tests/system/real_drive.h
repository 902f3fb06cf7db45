// Makes a map from some photos of a real COLMAP model, and queries from the others.
#ifndef CAIRN_TESTS_SYSTEM_REAL_DRIVE_H_
#define CAIRN_TESTS_SYSTEM_REAL_DRIVE_H_

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/localizer.h"
#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "eval/stated_focal.h"
#include "http/client.h"
#include "http/server.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn::testing {

struct RealDriveInput {
  std::filesystem::path model_dir;
  std::filesystem::path database_path;
  std::filesystem::path image_dir;
  // Returns the camera positions of a reconstruction's images.
  std::function<std::vector<CameraPosition>(const Reconstruction&)> positions;
  GeoregisterOptions georegister;
  // Returns true if an image is a query. All other images make the map.
  std::function<bool(const std::string& image_name)> is_query;
  // Returns true if an image is neither mapped nor asked. Optional.
  std::function<bool(const std::string& image_name)> is_left_out;
};

// The files and positions of the real drives. `is_query` is left to the test.
RealDriveInput LundInput();
RealDriveInput KittiInput();
RealDriveInput HerzJesusInput();

// The way in which queries reach the engine.
enum class QueryRoute {
  kInProcessFeatures,  // The model's own keypoints and descriptors.
  kServerFeatures,
  kInProcessImage,  // SIFT extracted from the photo.
  kServerImage,
};

// Builds the map once. The reference poses of the queries are those of the full model. The poses
// that the full model shares with the map place the model.
class RealDrive {
 public:
  explicit RealDrive(const RealDriveInput& input);
  ~RealDrive();

  const IngestReport& ingest_report() const { return ingest_report_; }
  const Georegistration& georegistration() const { return georegistration_; }
  const std::vector<EvalQuery>& queries() const { return queries_; }

  EvalReport Run(QueryRoute route, const StatedFocalOptions& focal = {});
  const Localizer& localizer() const { return *localizer_; }

 private:
  LocalizeResult LocalizeBy(QueryRoute route, const EvalQuery& query);

  TempDir dir_;
  Georegistration georegistration_;
  IngestReport ingest_report_;
  std::vector<EvalQuery> queries_;
  std::unique_ptr<Localizer> localizer_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<LocalizeClient> client_;
};

// Distance and angle between two answers to the same query.
double PositionDifferenceM(const LocalizeResult& a, const LocalizeResult& b);
double RotationDifferenceRad(const LocalizeResult& a, const LocalizeResult& b);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SYSTEM_REAL_DRIVE_H_
