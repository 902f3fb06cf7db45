#include "mapping/growth/gps_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mapping/growth/draft.h"

namespace cairn {
namespace {

constexpr double kStepM = 3.0;
constexpr double kAccuracyM = 5.0;  // 3.3 m an axis.

// A walk of photos without keypoints, with noisy positions.
PhotoSet Walk(int num_photos, uint64_t seed) {
  const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.0, 8.0, 400.0));
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> noise(0.0, kAccuracyM / 1.51);
  PhotoSet set;
  set.cameras.push_back({Camera(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 320.0, 240.0}),
                         {},
                         FocalSource::kCalibration});
  for (int i = 0; i < num_photos; ++i) {
    MappingPhoto photo;
    photo.name = std::to_string(i);
    photo.descriptors = ByteDescriptorMatrix(0, 128);
    photo.gps = GeodeticFromEcef(
        ecef_from_enu * Eigen::Vector3d(kStepM * i + noise(rng), noise(rng), 2.0 * noise(rng)));
    photo.gps_accuracy_m = kAccuracyM;
    set.photos.push_back(photo);
  }
  return set;
}

// Where the model has a photo, in units of half a meter.
Rigid3d PoseAt(double x_m, double y_m = 0.0) {
  return {Eigen::Quaterniond::Identity(), {-2.0 * x_m, -2.0 * y_m, 0.0}};
}

int CountContradicted(const PhotoSet& set, const Draft& draft) {
  const GpsCheck gps(set, draft, 15.0, 1);
  int count = 0;
  for (const int photo : draft.photos()) {
    count += gps.Contradicts(photo, draft.PoseOf(photo)) ? 1 : 0;
  }
  return count;
}

TEST(GpsCheck, BelievesAWalkInItsPlace) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const PhotoSet set = Walk(30, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 30; ++i) {
      draft.Add(i, PoseAt(kStepM * i));
    }
    EXPECT_EQ(CountContradicted(set, draft), 0) << seed;
  }
}

// The last photos show a facade that repeats after 30 m, and stand where its first copy is.
class GpsCheckOfCopies : public ::testing::TestWithParam<int> {};

TEST_P(GpsCheckOfCopies, ContradictsThoseWithFewerPhotos) {
  const int num_at_first = GetParam();
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const PhotoSet set = Walk(30, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 30; ++i) {
      draft.Add(i, PoseAt(kStepM * (i < num_at_first ? i : i - 10)));
    }
    const GpsCheck gps(set, draft, 15.0, 1);
    for (int i = 0; i < 30; ++i) {
      EXPECT_EQ(gps.Contradicts(i, draft.PoseOf(i)), i >= num_at_first) << seed << ": " << i;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Shares, GpsCheckOfCopies, ::testing::Values(20, 17));

// Eight positions on two places 30 m apart, which a draft takes for one: a fit to all of them
// contradicts none, but they err by much more than they state.
TEST(GpsCheck, FewPositionsOfTwoPlacesErrMoreThanTheyState) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    PhotoSet set = Walk(8, seed);
    const TrackTable tracks(set, {});
    Draft right(set, tracks, {set.cameras[0].camera}, 1), wrong = right;
    for (int i = 0; i < 8; ++i) {
      right.Add(i, PoseAt(kStepM * i));
      wrong.Add(i, PoseAt(kStepM * i));
    }
    EXPECT_LT(GpsCheck(set, right, 15.0, 1).noise_of_stated(), 2.0) << seed;
    const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.0, 8.0, 400.0));
    for (int i = 1; i < 8; i += 2) {
      const Eigen::Vector3d away_in_ecef = EcefFromGeodetic(*set.photos[i].gps) +
                                           ecef_from_enu.rotation * Eigen::Vector3d(0.0, 30.0, 0.0);
      set.photos[i].gps = GeodeticFromEcef(away_in_ecef);
    }
    EXPECT_GT(GpsCheck(set, wrong, 15.0, 1).noise_of_stated(), 2.0) << seed;
  }
}

// Receivers that claim too much do not cost photos.
TEST(GpsCheck, SeesThatAllPositionsErrMoreThanTheyState) {
  PhotoSet set = Walk(30, 7);
  for (MappingPhoto& photo : set.photos) {
    photo.gps_accuracy_m = kAccuracyM / 4.0;
  }
  const TrackTable tracks(set, {});
  Draft draft(set, tracks, {set.cameras[0].camera}, 1);
  for (int i = 0; i < 30; ++i) {
    draft.Add(i, PoseAt(kStepM * i));
  }
  EXPECT_EQ(CountContradicted(set, draft), 0);
}

TEST(GpsCheck, ChecksNothingIfAllPositionsAreTheSame) {
  PhotoSet set = Walk(4, 1);
  const TrackTable tracks(set, {});
  Draft draft(set, tracks, {set.cameras[0].camera}, 1);
  for (int i = 0; i < 4; ++i) {
    set.photos[i].gps = set.photos[0].gps;
    draft.Add(i, PoseAt(kStepM * i));
  }
  EXPECT_EQ(CountContradicted(set, draft), 0);
}

// The positions err to the other side of the walk, so the fit is upside down: it puts a photo on
// one sidewalk at the other.
TEST(GpsCheck, BelievesAPhotoBesideAStraightWalk) {
  constexpr double kBesideM = 8.0;
  const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.0, 8.0, 400.0));
  const auto gps_at = [&](double x_m, double y_m) {
    return GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(x_m, y_m, 0.0));
  };
  PhotoSet set = Walk(31, 1);
  const TrackTable tracks(set, {});
  Draft draft(set, tracks, {set.cameras[0].camera}, 1);
  for (int i = 0; i < 30; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    set.photos[i].gps = gps_at(kStepM * i, -0.5 * side);
    draft.Add(i, PoseAt(kStepM * i, 0.1 * side));
  }
  set.photos[30].gps = gps_at(45.0, kBesideM);
  const GpsCheck gps(set, draft, 15.0, 1);
  EXPECT_FALSE(gps.Contradicts(30, PoseAt(45.0, kBesideM)));
  EXPECT_TRUE(gps.Contradicts(30, PoseAt(0.0, kBesideM)));
}

TEST(GpsCheck, FindsThePositionThatIsFarOff) {
  PhotoSet set = Walk(30, 9);
  set.photos[11].gps->lat_rad += 1.6e-5;  // 100 m.
  const TrackTable tracks(set, {});
  Draft draft(set, tracks, {set.cameras[0].camera}, 1);
  for (int i = 0; i < 30; ++i) {
    draft.Add(i, PoseAt(kStepM * i));
  }
  const GpsCheck gps(set, draft, 15.0, 1);
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(gps.Contradicts(i, draft.PoseOf(i)), i == 11) << i;
  }
}

// A position 60 m beside the walk: the other photos are near the pose. A photo 60 m along the walk
// from its position: those there are near the position.
TEST(GpsCheck, TellsWhetherOthersAreNearThePoseOrThePosition) {
  using Nearer = GpsCheck::Nearer;
  PhotoSet set = Walk(30, 9);
  set.photos[5].gps->lat_rad += 1e-5;
  set.photos[8].gps.reset();
  const TrackTable tracks(set, {});
  Draft draft(set, tracks, {set.cameras[0].camera}, 1);
  for (int i = 0; i < 30; ++i) {
    draft.Add(i, PoseAt(kStepM * i));
  }
  const GpsCheck gps(set, draft, 15.0, 1);
  EXPECT_EQ(gps.NearerTo(6, 5, draft.PoseOf(5)), Nearer::kPose);
  EXPECT_EQ(gps.NearerTo(6, 25, draft.PoseOf(5)), Nearer::kPose);
  EXPECT_EQ(gps.NearerTo(24, 25, draft.PoseOf(5)), Nearer::kPosition);
  EXPECT_EQ(gps.NearerTo(15, 25, draft.PoseOf(5)), Nearer::kNeither);
  EXPECT_EQ(gps.NearerTo(8, 25, draft.PoseOf(5)), Nearer::kNeither);
  EXPECT_EQ(gps.NearerTo(6, 8, draft.PoseOf(5)), Nearer::kNeither);
}

// Photos of two copies 15 m apart, which stand in one place: too short for the scale to be known to
// a quarter, and long enough to contradict a copy.
TEST(GpsCheck, ContradictsACopyOfAShortWalk) {
  int num_found = 0, num_known = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const PhotoSet set = Walk(11, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 11; ++i) {
      draft.Add(i, PoseAt(kStepM * (i < 6 ? i : i - 6)));
    }
    num_known += GpsCheck(set, draft, 15.0, 1).KnowsPlace() ? 1 : 0;
    num_found += CountContradicted(set, draft) > 0 ? 1 : 0;
  }
  EXPECT_LE(num_known, 12);
  EXPECT_GE(num_found, 14);
}

// Where all photos are in one place, the positions spread by their errors.
TEST(GpsCheck, KnowsNoPlaceOfPhotosThatStandTogether) {
  int num_known = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    PhotoSet set = Walk(5, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.0, 8.0, 400.0));
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d back(-kStepM * i, 0.0, 0.0);
      set.photos[i].gps =
          GeodeticFromEcef(EcefFromGeodetic(*set.photos[i].gps) + ecef_from_enu.rotation * back);
      draft.Add(i, PoseAt(0.01 * i));
    }
    num_known += GpsCheck(set, draft, 15.0, 1).KnowsPlace() ? 1 : 0;
  }
  EXPECT_LE(num_known, 2);
}

// One position that is 100 m off, among few, is no step.
TEST(GpsCheck, FindsNoStepInOnePosition) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    PhotoSet set = Walk(10, seed);
    set.photos[3].gps->lat_rad += 1.6e-5;
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 10; ++i) {
      draft.Add(i, PoseAt(kStepM * i));
    }
    EXPECT_TRUE(GpsCheck(set, draft, 15.0, 1).BeyondStep().empty()) << seed;
  }
}

// A copy that is 17 m off: too little for many a photo with 5 m of accuracy, too much for a row.
TEST(GpsCheck, FindsTheStepOfARowOfPhotos) {
  int num_exact = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const PhotoSet set = Walk(30, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 30; ++i) {
      draft.Add(i, PoseAt(kStepM * i - (i >= 20 ? 17.0 : 0.0)));
    }
    const std::vector<int> beyond = GpsCheck(set, draft, 15.0, 1).BeyondStep();
    ASSERT_FALSE(beyond.empty()) << seed;
    EXPECT_NEAR(beyond.front(), 20, 2) << seed;
    EXPECT_EQ(beyond.back(), 29) << seed;
    num_exact += beyond.front() == 20 ? 1 : 0;
  }
  EXPECT_GE(num_exact, 17);
}

// Noise, a bias that changes slowly, and the bend of a draft are no steps.
TEST(GpsCheck, FindsNoStepInAWalkThatBends) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const PhotoSet set = Walk(40, seed);
    const TrackTable tracks(set, {});
    Draft draft(set, tracks, {set.cameras[0].camera}, 1);
    for (int i = 0; i < 40; ++i) {
      draft.Add(i, PoseAt(kStepM * i, 4.0 * std::sin(0.1 * i)));
    }
    EXPECT_TRUE(GpsCheck(set, draft, 15.0, 1).BeyondStep().empty()) << seed;
  }
}

}  // namespace
}  // namespace cairn
