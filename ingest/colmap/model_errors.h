// Tells whether a model's points are where its photos see them. Private to ingest/colmap.
#ifndef CAIRN_INGEST_COLMAP_MODEL_ERRORS_H_
#define CAIRN_INGEST_COLMAP_MODEL_ERRORS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/scene/reconstruction.h"

namespace cairn {

// Positions of cameras do not depend on their focal lengths, and landmarks are triangulated again.
// So a model whose cameras have the parameters of another size of the photos fits its positions,
// and makes a map whose answers are all wrong. Its own points contradict it.
class ModelErrors {
 public:
  // `landmark` has the position that the model gives it.
  void Add(const Reconstruction& reconstruction, const ReconLandmark& landmark);

  // A sentence if half of the observations are off by more than 8 px and 0.5 % of the long side.
  // COLMAP keeps none of more than 4 px; a focal length that is 5 % off makes a larger median.
  std::optional<std::string> Fault() const;

 private:
  std::vector<double> errors_px_, relative_;  // By observation; the latter over the long side.
};

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_MODEL_ERRORS_H_
