// How well a direction explains, as up, all that is known about a reconstruction. Private to
// ingest/place. docs/math/localization.md has the formulas.
#ifndef CAIRN_INGEST_PLACE_UP_EVIDENCE_H_
#define CAIRN_INGEST_PLACE_UP_EVIDENCE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "ingest/place/picture_up.h"
#include "ingest/place/similarity_problem.h"

namespace cairn {

struct UpView {
  Eigen::Quaterniond cam_from_world = Eigen::Quaterniond::Identity();
  std::optional<PictureUp> stated;  // By the EXIF or the user.
  double trust = 0.0;       // Probability that `stated` is right if a sensor or a user stated it.
  bool is_by_user = false;  // A user knows how a camera was held that looks down, too.
  std::optional<Eigen::Vector3d> up_in_cam;  // Measured by an accelerometer; a unit vector.
};

struct UpProblem {
  std::vector<UpView> views;
  std::vector<SimilarityProblem::Position> positions;
  std::vector<Eigen::Vector3d> rays_in_world;  // From a camera to a landmark that it sees.
  double trust_in_statements = 1.0;  // Probability that a sensor or a user made those of the views.
  double roll_sigma_rad = 0.1;       // Of a camera that is held in one of the ways of PictureUp.
};

// How often each way of PictureUp occurs in a session, and at last how often none does.
using HoldShares = std::array<double, kPictureUps.size() + 1>;

// Logarithms of likelihoods.
struct UpScore {
  double cameras = 0.0;    // Rolls and pitches, with the prior of the ways in which people hold.
  double stated = 0.0;     // What EXIF and user add to that.
  double positions = 0.0;  // Fit of a similarity with this up to the positions, and its slope.
  double ground = 0.0;     // A camera near the ground sees nothing far below.
  HoldShares shares = {};
  bool heeds_statements = false;  // Rather than holding that those of the session say nothing.

  double Total() const { return cameras + stated + positions + ground; }
};

class UpEvidence {
 public:
  explicit UpEvidence(const UpProblem& problem);

  UpScore Score(const Eigen::Vector3d& up_in_world) const;

  // The likeliest way in which a camera was held.
  PictureUp HoldOf(const UpView& view, const Eigen::Vector3d& up_in_world,
                   const UpScore& score) const;

  // A similarity to the known positions, for directions to start from. It may be turned about the
  // line of a straight walk.
  const Sim3d& loose_enu_from_world() const { return loose_enu_from_world_; }
  // Unit vector along which the cameras spread most.
  const Eigen::Vector3d& line_in_world() const { return line_in_world_; }
  const UpProblem& problem() const { return problem_; }

 private:
  using Densities = std::array<double, kPictureUps.size() + 1>;

  void PreparePositions();
  void PrepareStatements();
  // The sine of the pitch that most photos share.
  double SharedPitch(const Eigen::Vector3d& up_in_world) const;
  Densities DensitiesOf(const UpView& view, const Eigen::Vector3d& up_in_world,
                        double shared_pitch) const;
  static double ScoreHolds(const std::vector<Densities>& densities, HoldShares* shares);
  void ScoreStatements(std::vector<Densities> densities, UpScore* score) const;
  double ScorePositions(const Eigen::Vector3d& up_in_world, double* enu_per_world) const;
  double ScoreGround(const Eigen::Vector3d& up_in_world, double enu_per_world) const;
  double ScoreFlight(double enu_per_world) const;

  UpProblem problem_;
  std::vector<double> weights_;  // Of the positions: small for outliers.
  Sim3d loose_enu_from_world_;
  Eigen::Vector3d line_in_world_ = Eigen::Vector3d::UnitX();
  bool has_stated_ = false;
  // Probabilities of what the session states if it was made up, and if all cameras look down.
  double made_up_ = 1.0, said_from_above_ = 1.0;
  // Lengths of which a tenth of the rays are shorter, and longer.
  double near_ray_in_world_ = 0.0, far_ray_in_world_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_UP_EVIDENCE_H_
