#include "core/require.h"
#include "mapping/growth/grow_segments.h"

namespace cairn {

void GrowthOptions::Validate() const {
  RequireWithin("growth.min_inliers", min_inliers, 6, 10'000);
  RequireWithin("growth.min_link_share", min_link_share, 0.0, 1.0);
  RequireWithin("growth.min_witnesses", min_witnesses, 1, 100);
  RequireWithin("growth.max_rotation_error_rad", max_rotation_error_rad, 1e-4, 1.0);
  RequireWithin("growth.max_direction_error_rad", max_direction_error_rad, 1e-4, 1.5);
  RequireWithin("growth.default_gps_accuracy_m", default_gps_accuracy_m, 0.01, 1e5);
  RequireWithin("growth.adjust_after_growth", adjust_after_growth, 0.01, 10.0);
  RequireWithin("growth.min_photos", min_photos, 3, 1000);
  RequireWithin("growth.num_threads", num_threads, 1, 1024);
}

const char* ExplainVerdict(PhotoVerdict verdict) {
  switch (verdict) {
    case PhotoVerdict::kInSegment:
      return "is in the map";
    case PhotoVerdict::kNoTwoView:
      return "no other photo shows enough of what it shows";
    case PhotoVerdict::kNoSeed:
      return "it shows what others show, but no three of them agree on where they were taken";
    case PhotoVerdict::kTooFewInliers:
      return "too little of what it shows is in the map";
    case PhotoVerdict::kWeakSupport:
      return "it shows much more of what photos outside of the map show";
    case PhotoVerdict::kContradicted:
      return "photos of the map that it was compared with contradict its place";
    case PhotoVerdict::kGpsContradicts:
      return "its GPS position contradicts its place";
    case PhotoVerdict::kLostSupport:
      return "what it shows did not fit the map after the adjustment";
  }
  return "";
}

}  // namespace cairn
