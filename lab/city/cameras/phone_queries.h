// Photos that people take on the sidewalk, with what their phones know about where that is.
#ifndef CAIRN_LAB_CITY_CAMERAS_PHONE_QUERIES_H_
#define CAIRN_LAB_CITY_CAMERAS_PHONE_QUERIES_H_

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "core/rigid3.h"
#include "eval/eval_query.h"
#include "lab/city/cameras/detector.h"
#include "lab/city/geometry/city.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// What a phone's sensors get wrong. Nothing may be negative.
struct PhoneNoise {
  // GPS: the standard deviation per horizontal axis is drawn for each query, with this median and
  // this standard deviation of its logarithm, metres;
  double gps_median_m = 8.0;
  double gps_log_sigma = 0.5;
  // this share of the positions is off by three times as much, unknown to the phone: [0, 1];
  double gps_outlier_share = 0.06;
  // and houses push positions across the street, by this standard deviation where they are as high
  // as the street is wide, metres. Varies over some 60 m.
  double canyon_bias_m = 10.0;
  double height_sigma_m = 8.0;
  // Of the logarithm of the reported accuracy against the true one.
  double accuracy_log_sigma = 0.4;
  double gravity_sigma_rad = 0.012;     // Of the tilt about each of two axes.
  double focal_log_sigma = 0.007;       // Of the reported focal length.
  double principal_point_sigma_px = 3;  // Of the reported principal point.

  void Validate() const;
};

struct PhoneQueryOptions {
  int num_queries = 100;    // [1, 1000000]
  int num_keypoints = 750;  // Of a query, [10, 20000].
  // Of the keypoints, that show a thing of which the map has a landmark, [0, 1]: the median over
  // the queries. If fewer are in view, there are fewer.
  double mapped_fraction = 0.04;
  // Standard deviation of the logarithm of a query's own fraction, [0, 3]: some photos show little
  // that lasts. With these defaults the mean is 0.09, and one query in six has a quarter of the
  // median or less: few keypoints, or too few for any method.
  double mapped_log_sigma = 1.3;
  // Of the other keypoints, at most so many show things in the city that the map lacks (new ones,
  // small ones, ornaments seen elsewhere), [0, 1]; the rest shows nothing that is anywhere.
  double unmapped_share = 0.5;
  double time_years = 2.5;       // After the first mapping pass, [0, 200].
  int num_appearance_modes = 4;  // As MappingOptions has; each query has one of them.
  int image_width_px = 720;      // [64, 8192]
  int image_height_px = 960;     // [64, 8192]
  double focal_px = 760.0;       // [20, 20000]
  double height_m = 1.5;         // Of the phone, [0.2, 4].
  DetectorOptions detector = {.max_keypoints = 6000};
  PhoneNoise noise;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Where a phone is, in site.
struct PhonePlace {
  Rigid3d cam_from_site;
  double street_yaw_rad = 0.0;
  double canyon = 0.0;  // Mean height of the houses over the width of the street.
};

// A phone beside `street`.
PhonePlace PlaceBeside(const City& city, const CityStreet& street, const Rigid3d& cam_from_site);

// The queries of one city; each is a pure function of its number and the map. Immutable; safe to
// use from any thread. `city` and `model` must outlive it.
class PhoneQueries {
 public:
  // At places drawn by the seed: on a sidewalk within the city's square, upright, looking across
  // the street to some degree. Throws Error(kInvalidArgument) as PhoneQueryOptions::Validate.
  PhoneQueries(const City& city, const DescriptorModel& model, const PhoneQueryOptions& options);
  // At the places given; options.num_queries and height_m have no meaning.
  PhoneQueries(const City& city, const DescriptorModel& model, const PhoneQueryOptions& options,
               std::vector<PhonePlace> places);

  int size() const { return static_cast<int>(places_.size()); }
  const PhoneQueryOptions& options() const { return options_; }

  const PhonePlace& Place(int query_idx) const { return places_[static_cast<size_t>(query_idx)]; }

  // The query with its true pose, camera, prior and gravity. `mapped` holds the CityLandmark::id
  // of what the map has around it (see MappedChunk::city_landmarks).
  EvalQuery Make(int query_idx, const std::unordered_set<uint64_t>& mapped) const;

 private:
  // At most so many keypoints of an image show things that are mapped.
  int NumMapped(uint64_t image_id) const;
  void FillFeatures(int query_idx, const std::unordered_set<uint64_t>& mapped,
                    FeatureSet* features) const;
  void FillPrior(int query_idx, LocalizeQuery* query) const;

  const City& city_;
  const DescriptorModel& model_;
  PhoneQueryOptions options_;
  Camera camera_;  // The true one.
  std::vector<PhonePlace> places_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERAS_PHONE_QUERIES_H_
