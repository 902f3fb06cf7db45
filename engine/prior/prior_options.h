// Options of the prior stage.
#ifndef CAIRN_ENGINE_PRIOR_PRIOR_OPTIONS_H_
#define CAIRN_ENGINE_PRIOR_PRIOR_OPTIONS_H_

namespace cairn {

struct PriorOptions {
  // The search reaches this many standard deviations of the prior, per axis. 3 leaves 1 % outside.
  double search_sigmas = 3.0;
  // Bounds on the search radius, metres. The lower one guards against receivers that claim too
  // much: in a simulated old town, where houses push positions across the street, 50 m answer 5 %
  // more of the queries than 25 m, for a sixth more time; more sigmas gain nothing on top.
  double min_radius_m = 50.0;
  double max_radius_m = 500.0;
  // The reported accuracy is taken as at least this, metres.
  double min_accuracy_m = 3.0;

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PRIOR_PRIOR_OPTIONS_H_
