// Simulates photos that people take on the sidewalk, together with the position that their phones
// report.
#ifndef CAIRN_LAB_CITY_PHONE_QUERIES_H_
#define CAIRN_LAB_CITY_PHONE_QUERIES_H_

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "core/rigid3.h"
#include "eval/eval_query.h"
#include "lab/city/city.h"
#include "lab/city/detector.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// Errors of a phone's sensors. No value may be negative.
struct PhoneNoise {
  // GPS error: each query draws its standard deviation per horizontal axis, in meters, from a
  // log-normal distribution with this median and this standard deviation of the logarithm.
  double gps_median_m = 8.0;
  double gps_log_sigma = 0.5;
  // Share of the positions that are off by three times as much without the phone's knowledge, [0,
  // 1].
  double gps_outlier_share = 0.06;
  // Houses push positions across the street. This is the standard deviation in meters where the
  // houses are as high as the street is wide. The push varies over about 60 m.
  double canyon_bias_m = 10.0;
  double height_sigma_m = 8.0;
  // Standard deviation of log(reported accuracy / true accuracy).
  double accuracy_log_sigma = 0.4;
  double gravity_sigma_rad = 0.012;     // Tilt about each of two axes.
  double focal_log_sigma = 0.007;       // Log of the reported focal length.
  double principal_point_sigma_px = 3;  // Reported principal point.

  void Validate() const;
};

struct PhoneQueryOptions {
  int num_queries = 100;    // [1, 1000000]
  int num_keypoints = 750;  // Per query, [10, 20000].
  // Share of the keypoints that show a point with a landmark in the map, [0, 1]: the median over
  // the queries. A query has fewer of them if fewer are in view.
  double mapped_fraction = 0.04;
  // Standard deviation of the logarithm of a query's own share, [0, 3]: some photos show little
  // that lasts. With the defaults, the mean share is 0.09, and one query in six has a quarter of
  // the median or less: few keypoints, or too few for any method.
  double mapped_log_sigma = 1.3;
  // Largest share of the other keypoints that show things of the city that the map lacks, [0, 1]:
  // new things, small ones, ornaments seen elsewhere. The remaining keypoints show nothing that
  // exists in the city.
  double unmapped_share = 0.5;
  double time_years = 2.5;       // After the first mapping pass, [0, 200].
  int num_appearance_modes = 4;  // Same as in SimulatedMappingOptions; each query has one mode.
  int image_width_px = 720;      // [64, 8192]
  int image_height_px = 960;     // [64, 8192]
  double focal_px = 760.0;       // [20, 20000]
  double height_m = 1.5;         // Height of the phone, [0.2, 4].
  DetectorOptions detector = {.max_keypoints = 6000};
  PhoneNoise noise;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// The place of a phone, in site.
struct PhonePlace {
  Rigid3d cam_from_site;
  double street_yaw_rad = 0.0;
  double canyon = 0.0;  // Mean height of the houses divided by the width of the street.
};

// The place of a phone beside `street`.
PhonePlace PlaceBeside(const City& city, const CityStreet& street, const Rigid3d& cam_from_site);

// The queries of one city. Each query is a pure function of its number and the map. Immutable; safe
// to use from any thread. `city` and `model` must outlive the object.
class PhoneQueries {
 public:
  // Draws the places by the seed: on a sidewalk within the city's square, upright, looking more or
  // less across the street. Throws the Error(kInvalidArgument) of PhoneQueryOptions::Validate.
  PhoneQueries(const City& city, const DescriptorModel& model, const PhoneQueryOptions& options);
  // Uses the given places. Ignores options.num_queries and options.height_m.
  PhoneQueries(const City& city, const DescriptorModel& model, const PhoneQueryOptions& options,
               std::vector<PhonePlace> places);

  int size() const { return static_cast<int>(places_.size()); }
  const PhoneQueryOptions& options() const { return options_; }

  const PhonePlace& Place(int query_idx) const { return places_[static_cast<size_t>(query_idx)]; }

  // Returns a query with its true pose, camera, prior and gravity. `mapped` holds the
  // CityLandmark::id of each mapped landmark around the query (see MappedChunk::city_landmarks).
  EvalQuery Make(int query_idx, const std::unordered_set<uint64_t>& mapped) const;

 private:
  // Largest number of an image's keypoints that show mapped landmarks.
  int NumMapped(uint64_t image_id) const;
  void FillFeatures(int query_idx, const std::unordered_set<uint64_t>& mapped,
                    FeatureSet* features) const;
  void FillPrior(int query_idx, LocalizeQuery* query) const;

  const City& city_;
  const DescriptorModel& model_;
  PhoneQueryOptions options_;
  Camera camera_;  // The true camera.
  std::vector<PhonePlace> places_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_PHONE_QUERIES_H_
