#include "fusion/map_updates/alignment_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Eigen::Vector3d kPlace(1.0, 2.0, 0.0);

AlignmentCandidate CandidateAt(int64_t frame_id, double east_m) {
  return {frame_id, Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(east_m, 0.0, 0.0)), {}};
}

std::vector<int64_t> FramesOf(const std::vector<const AlignmentCandidate*>& candidates) {
  std::vector<int64_t> frame_ids;
  for (const AlignmentCandidate* candidate : candidates) {
    frame_ids.push_back(candidate->frame_id);
  }
  return frame_ids;
}

TEST(AlignmentCandidates, WaitUntilEnoughAgree) {
  AlignmentCandidates candidates;
  candidates.Add(CandidateAt(1, 0.0));
  candidates.Add(CandidateAt(2, 40.0));
  candidates.Add(CandidateAt(3, 0.3));
  EXPECT_THAT(candidates.Agreeing(kPlace), IsEmpty());
  candidates.Add(CandidateAt(4, 0.1));
  EXPECT_THAT(FramesOf(candidates.Agreeing(kPlace)), ElementsAre(1, 3, 4));
}

TEST(AlignmentCandidates, TheOldestMakesWay) {
  AlignmentCandidates candidates;
  for (int64_t frame_id = 1; frame_id <= 5; ++frame_id) {
    EXPECT_EQ(candidates.Add(CandidateAt(frame_id, 20.0 * static_cast<double>(frame_id))),
              std::nullopt);
  }
  EXPECT_EQ(candidates.Add(CandidateAt(6, 0.0)), 1);
  EXPECT_FALSE(candidates.HasFrame(1));
  EXPECT_TRUE(candidates.HasFrame(2));
  EXPECT_TRUE(candidates.HasFrame(6));
}

TEST(AlignmentCandidates, GiveAllFramesBack) {
  AlignmentCandidates candidates;
  EXPECT_TRUE(candidates.empty());
  candidates.Add(CandidateAt(3, 0.0));
  candidates.Add(CandidateAt(8, 0.0));
  EXPECT_FALSE(candidates.empty());
  EXPECT_THAT(candidates.Release(), ElementsAre(3, 8));
  EXPECT_TRUE(candidates.empty());
  EXPECT_FALSE(candidates.HasFrame(8));
}

}  // namespace
}  // namespace cairn::fusion
