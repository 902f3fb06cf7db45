// Options of the prior stage.
#ifndef CAIRN_ENGINE_TILES_PRIOR_OPTIONS_H_
#define CAIRN_ENGINE_TILES_PRIOR_OPTIONS_H_

namespace cairn {

struct PriorOptions {
  // Radius of the search in standard deviations of the prior, per axis. 3 leaves 1 % outside.
  double search_sigmas = 3.0;
  // Bounds on the search radius, meters. The lower bound guards against receivers that report too
  // small an error. In a simulated old town, where houses push positions across the street, 50 m
  // answer 5 % more queries than 25 m and take a sixth more time; a larger search_sigmas then gains
  // nothing.
  double min_radius_m = 50.0;
  double max_radius_m = 500.0;

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_PRIOR_OPTIONS_H_
