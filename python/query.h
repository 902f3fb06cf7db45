// One query as Python states it, and its answer by a map or by a server.
#ifndef CAIRN_PYTHON_QUERY_H_
#define CAIRN_PYTHON_QUERY_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/features/feature_extractor.h"
#include "core/rigid3.h"
#include "engine/localizer.h"
#include "engine/query/localize_query.h"
#include "python/camera.h"
#include "python/camera_input.h"
#include "python/result.h"

namespace cairn::python {

struct RigInput {
  CameraInput input;
  Camera camera;
  Rigid3d cam_from_first;
};

struct StatedQuery {
  CameraInput input;
  std::optional<StatedCamera> camera;
  std::vector<RigInput> rig;
  std::optional<PositionPrior> prior;
  bool exif_prior = true;
  std::optional<Eigen::Vector3d> down_in_cam;
  std::optional<int> timeout_ms;
};

// cairn.Query: the checked arguments of a query. `owners` are the objects of Python whose bytes and
// pixels the query refers to.
struct PythonQuery {
  StatedQuery stated;
  std::vector<py::object> owners;
};

// Throws Error(kInvalidArgument) that names the argument.
PythonQuery MakeQuery(const py::object& image, const py::object& camera, const py::object& prior,
                      const py::object& accuracy_m, const py::object& gravity,
                      const py::object& rig, const py::object& timeout_ms,
                      const py::object& exif_prior);

// The query of a call of `localize`: as MakeQuery, or a cairn.Query as `image`, which no other
// argument may accompany.
PythonQuery QueryOfCall(const py::object& image, const py::object& camera, const py::object& prior,
                        const py::object& accuracy_m, const py::object& gravity,
                        const py::object& rig, const py::object& timeout_ms,
                        const py::object& exif_prior);

// A cairn.Query, or the image of one without further arguments.
PythonQuery QueryOf(const std::string& argument, const py::object& value);

// A query with the features of its cameras, which are lent to it.
struct LentQuery {
  LocalizeQuery query;
  std::vector<std::unique_ptr<FeatureLoan>> loans;
  double decode_seconds = 0.0;
  double extract_seconds = 0.0;
};

// Reads the pictures and extracts their features as `cairn localize` does. What the query does not
// say is taken from the EXIF of its picture: the camera and, with exif_prior, the position.
// `descriptor_type` is that of the map, or empty if it has none yet. Does not need the GIL. Throws
// Error with the argument or the file; as FeatureExtractor::Extract. The result refers to itself:
// it stays where it is.
void FillQuery(const StatedQuery& stated, const FeatureExtractor& extractor,
               const std::string& descriptor_type, LentQuery* filled);

// Everything of the query but its features. `exif` is that of the picture, or null for features.
LocalizeQuery QueryWithoutFeatures(const StatedQuery& stated, const ExifInfo* exif, int width_px,
                                   int height_px);

void BindQuery(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_QUERY_H_
