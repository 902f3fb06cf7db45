#include "mapping/pairs/divide_polls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/geodesy.h"

namespace cairn {
namespace {

// Photos along a street to the east, in no order, with positions good to 5 m.
PhotoSet Street(int num_photos, double step_m) {
  const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.4, 8.5, 0.0));
  PhotoSet set;
  for (int i = 0; i < num_photos; ++i) {
    MappingPhoto photo;
    const double east_m = step_m * (i * 7919 % num_photos);
    photo.gps = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(east_m, 3.0 * (i % 2), 0.0));
    photo.gps_accuracy_m = 5.0;
    set.photos.push_back(photo);
  }
  return set;
}

std::vector<Poll> Divide(const PhotoSet& set) {
  return DividePolls(Whereabouts(set, {}), static_cast<int>(set.photos.size()));
}

TEST(DividePolls, AskEachPhotoOnceAboutAllThatItMayMeet) {
  PhotoSet set = Street(2000, 0.7);
  set.photos[11].gps.reset();
  const Whereabouts whereabouts(set, {});
  std::set<int> asked;
  for (const Poll& poll : DividePolls(whereabouts, 2000)) {
    EXPECT_TRUE(std::is_sorted(poll.candidates.begin(), poll.candidates.end()));
    for (const int photo : poll.photos) {
      EXPECT_TRUE(asked.insert(photo).second);
      for (int other = 0; other < 2000; ++other) {
        EXPECT_TRUE(!whereabouts.MayMeet(photo, other) ||
                    std::binary_search(poll.candidates.begin(), poll.candidates.end(), other))
            << photo << " and " << other;
      }
    }
  }
  EXPECT_EQ(asked.size(), 2000u);
}

// What is compared with a photo does not grow with the street.
TEST(DividePolls, AreNotLargerInALongerStreet) {
  size_t most_of_short = 0, most_of_long = 0;
  for (const Poll& poll : Divide(Street(1000, 0.7))) {
    most_of_short = std::max(most_of_short, poll.candidates.size());
  }
  for (const Poll& poll : Divide(Street(4000, 0.7))) {
    most_of_long = std::max(most_of_long, poll.candidates.size());
  }
  EXPECT_LT(most_of_short, 600u);
  EXPECT_LT(most_of_long, 600u);
}

TEST(DividePolls, AreOneForFewPhotosAndForOnePlace) {
  EXPECT_EQ(Divide(Street(200, 0.7)).size(), 1u);
  EXPECT_EQ(Divide(Street(2000, 0.005)).size(), 1u);
}

// Lanes 60 m apart with a photo every 50 m, as from 150 m above the ground.
TEST(DividePolls, PhotosOfASurveyMeetTheirNeighborsInOtherLanes) {
  const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.4, 8.5, 0.0));
  PhotoSet set;
  for (int i = 0; i < 25; ++i) {
    MappingPhoto photo;
    photo.gps =
        GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(50.0 * (i % 5), 60.0 * (i / 5), 0));
    photo.gps_accuracy_m = 1.0;
    set.photos.push_back(photo);
  }
  const Whereabouts whereabouts(set, {});
  EXPECT_TRUE(whereabouts.MayMeet(12, 11));
  EXPECT_TRUE(whereabouts.MayMeet(12, 17));
  EXPECT_TRUE(whereabouts.MayMeet(12, 18));
  EXPECT_FALSE(whereabouts.MayMeet(0, 24));
}

TEST(DividePolls, APhotoWithAWrongPositionMeetsThoseThatAreNearest) {
  PhotoSet set = Street(50, 1.0);
  set.photos[20].gps->lon_rad += 1e-4;  // 430 m.
  const Whereabouts whereabouts(set, {});
  int num_met = 0;
  for (int other = 0; other < 50; ++other) {
    num_met += other != 20 && whereabouts.MayMeet(20, other) ? 1 : 0;
  }
  EXPECT_GE(num_met, 8);
}

TEST(DividePolls, AskPhotosWithoutAPositionAboutAll) {
  PhotoSet set = Street(30, 100.0);
  for (MappingPhoto& photo : set.photos) {
    photo.gps.reset();
  }
  const std::vector<Poll> polls = Divide(set);
  ASSERT_EQ(polls.size(), 1u);
  EXPECT_EQ(polls[0].photos.size(), 30u);
  EXPECT_EQ(polls[0].candidates.size(), 30u);
}

}  // namespace
}  // namespace cairn
