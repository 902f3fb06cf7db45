// The least-squares problem of georegistration, with minimal solutions as a start. Private to
// ingest/place.
#ifndef CAIRN_INGEST_PLACE_SIMILARITY_PROBLEM_H_
#define CAIRN_INGEST_PLACE_SIMILARITY_PROBLEM_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/rigid3.h"

namespace cairn {

// Scale of Cauchy's loss, in standard deviations of a residual.
inline constexpr double kLossScaleSigmas = 2.0;

// Photos tell up by their pitches, too: by a standard deviation of 0.3 rad each, of which ten are
// independent.
inline constexpr double kUpSigmaRad = 0.1;

// Finds the enu_from_world that maps camera centers to their known positions and level camera axes
// to the horizontal. All residuals are in units of their standard deviation and pass through
// Cauchy's loss.
struct SimilarityProblem {
  struct Position {
    Eigen::Vector3d center_in_world;
    Eigen::Vector3d center_in_enu;
    double accuracy_m = 1.0;
    double height_accuracy_m = 1.0;
  };
  std::vector<Position> positions;
  // The axes of all cameras that are horizontal by the way in which each was held (both axes of the
  // picture if it looks straight down), and the mean of the directions that are up by it; unit
  // vectors. Used if upright_sigma_rad > 0.
  std::vector<Eigen::Vector3d> right_in_world;
  Eigen::Vector3d mean_up_in_world = Eigen::Vector3d::Zero();
  double upright_sigma_rad = 0.0;
  // Up as the cameras say, with the standard deviation kUpSigmaRad. Similarities whose up is more
  // than 45 degrees away are no candidates.
  std::optional<Eigen::Vector3d> up_in_world;

  // The sum of the robust losses.
  double Cost(const Sim3d& enu_from_world) const;
};

// The sum of the squared errors of a position, in units of their standard deviations.
double SqResidual(const SimilarityProblem::Position& position, const Eigen::Vector3d& error_in_enu);

// The best of many similarities that three positions each determine, also three on a line, about
// which the result is then turned in any way. For telling outliers and for a first scale.
// Deterministic.
Sim3d LooseSimilarity(const std::vector<SimilarityProblem::Position>& positions);

// Returns the best of many minimal solutions. Some use three positions each (Umeyama 1991). With
// the upright prior, others use two positions each and take the vertical from the cameras, which
// also works on a straight line. Returns nothing if every sample is degenerate. Deterministic.
std::optional<Sim3d> InitialSimilarity(const SimilarityProblem& problem);

// Minimizes Cost, starting at `start`. Throws Error(kInternal) if the solver fails.
Sim3d RefineSimilarity(const SimilarityProblem& problem, const Sim3d& start);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_SIMILARITY_PROBLEM_H_
