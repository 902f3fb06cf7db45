// Asks a map for photos with known poses.
#ifndef CAIRN_TESTS_SUPPORT_RECOGNIZED_H_
#define CAIRN_TESTS_SUPPORT_RECOGNIZED_H_

#include <memory>
#include <vector>

#include "core/angles.h"
#include "engine/localizer.h"
#include "eval/eval_query.h"
#include "storage/map/map_store.h"

namespace cairn::testing {

// Returns which photos the map recognizes within 3 m and 10 degrees.
inline std::vector<bool> Recognized(const std::vector<EvalQuery>& queries, const MapStore& store) {
  const std::shared_ptr<const MapStore> shared(std::shared_ptr<const MapStore>(), &store);
  const Localizer localizer(shared, {}, size_t{256} << 20);
  std::vector<bool> recognized;
  for (const EvalQuery& query : queries) {
    const LocalizeResult result = localizer.Localize(query.query);
    const Rigid3d ecef_from_cam = result.cam_from_ecef.Inverse();
    const Rigid3d truth = query.cam_from_ecef.Inverse();
    recognized.push_back(
        result.localized && (ecef_from_cam.translation - truth.translation).norm() <= 3.0 &&
        ecef_from_cam.rotation.angularDistance(truth.rotation) <= 10.0 * kRadPerDeg);
  }
  return recognized;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_RECOGNIZED_H_
