// What a client asks: features of one image and what it knows about its pose.
#ifndef CAIRN_ENGINE_LOCALIZE_QUERY_H_
#define CAIRN_ENGINE_LOCALIZE_QUERY_H_

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <string>

#include "core/camera.h"
#include "core/features.h"
#include "core/geodesy.h"

namespace cairn {

// A rough position, as a GPS receiver reports it.
struct PositionPrior {
  Geodetic position;
  double accuracy_m = 15.0;  // Radius that holds the truth with 68 % probability.
  // Standard deviation of the height; nothing if the height is unknown or not to be trusted.
  std::optional<double> height_sigma_m;
};

struct LocalizeQuery {
  std::string id;  // Echoed; may be empty.
  Camera camera;
  FeatureSet features;  // Raw or projected; see DescriptorSpace.
  // Wire codec of projected features; must be the map's (Codebook::CodecName). Unused for raw ones.
  std::string codec;
  std::optional<PositionPrior> prior;          // Without it the whole map is searched.
  std::optional<Eigen::Vector3d> down_in_cam;  // Unit vector; without it P3P replaces two points.
  // The best answer found by then is returned; nothing means no deadline.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  // Throws Error(kBadInput) naming the field on non-finite numbers, an accuracy outside (0, 100
  // km], a gravity vector that is not of unit length within 1e-3, or inconsistent features.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZE_QUERY_H_
