#include "ingest/tiles/landmark_history.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

constexpr SessionId S(int64_t id) { return SessionId(id); }

TEST(AppendToHistory, SumsUpTheOldestOnceThereAreTooMany) {
  std::vector<HistoryEntry> history;
  for (int64_t id = 1; id <= 7; ++id) {
    AppendToHistory({S(id), static_cast<uint8_t>(id), 200}, &history);
  }
  ASSERT_EQ(history.size(), Tile::kMaxHistory);
  EXPECT_EQ(history[0], (HistoryEntry{SessionId{}, 1 + 2 + 3, 255}));
  EXPECT_EQ(history[1], (HistoryEntry{S(4), 4, 200}));
  EXPECT_EQ(history[4], (HistoryEntry{S(7), 7, 200}));
}

TEST(AppendToHistory, ASumJoinsTheSum) {
  std::vector<HistoryEntry> history = {{SessionId{}, 2, 3}, {S(1), 1, 1}};
  AppendToHistory({SessionId{}, 4, 5}, &history);
  EXPECT_EQ(history, (std::vector<HistoryEntry>{{SessionId{}, 6, 8}, {S(1), 1, 1}}));
  history = {{S(1), 1, 1}};
  AppendToHistory({SessionId{}, 4, 5}, &history);
  EXPECT_EQ(history, (std::vector<HistoryEntry>{{SessionId{}, 4, 5}, {S(1), 1, 1}}));
  history = {{S(1), 1, 2}, {S(2), 1, 2}, {S(3), 1, 2}, {S(4), 1, 2}, {S(5), 1, 2}};
  AppendToHistory({SessionId{}, 4, 5}, &history);
  ASSERT_EQ(history.size(), Tile::kMaxHistory);
  EXPECT_EQ(history[0], (HistoryEntry{SessionId{}, 5, 7}));
  EXPECT_EQ(history[1], (HistoryEntry{S(2), 1, 2}));
}

TEST(ExistenceProbability, AnObservationProvesIt) {
  const SessionTimes times = {{S(1), 0.0}, {S(2), 5.0}};
  const std::vector<HistoryEntry> history = {{S(1), 0, 9}, {S(2), 1, 9}};
  EXPECT_DOUBLE_EQ(ExistenceProbability(history, times, {}), 1.0);
}

TEST(ExistenceProbability, FallsWithEachMissAndWithTime) {
  const SessionTimes times = {{S(1), 0.0}, {S(2), 1.0}, {S(3), 2.0}, {S(4), 7.0}};
  std::vector<HistoryEntry> history = {{S(1), 4, 4}};
  double last = ExistenceProbability(history, times, {});
  for (const int64_t id : {2, 3, 4}) {
    history.push_back({S(id), 0, 3});
    const double now = ExistenceProbability(history, times, {});
    EXPECT_LT(now, last);
    last = now;
  }
  // The last miss came after five years: half of the certainty is gone before it.
  EXPECT_LT(last, 0.1);
}

TEST(ExistenceProbability, OneMissOfALandmarkThatIsRarelySeenSaysLittle) {
  const SessionTimes times = {{S(1), 0.0}, {S(2), 0.1}};
  const std::vector<HistoryEntry> rare = {{S(1), 1, 20}, {S(2), 0, 3}};
  const std::vector<HistoryEntry> steady = {{S(1), 20, 20}, {S(2), 0, 3}};
  EXPECT_GT(ExistenceProbability(rare, times, {}), ExistenceProbability(steady, times, {}));
}

TEST(ExpectedObservations, IsTheNumberOfObservationsWhileNothingIsMissed) {
  EXPECT_DOUBLE_EQ(ExpectedObservations(std::vector<HistoryEntry>{{S(1), 6, 6}}, {}, {}), 6.0);
  EXPECT_DOUBLE_EQ(ExpectedObservations(std::vector<HistoryEntry>{{S(1), 3, 6}}, {}, {}), 3.0);
}

TEST(TimesOf, CountsYears) {
  SessionRecord a, b;
  a.id = S(1);
  a.recorded_at = "2016-06-01T00:00:00Z";
  b.id = S(2);
  b.recorded_at = "2018-12-01T00:00:00Z";
  const SessionTimes times = TimesOf({a, b});
  EXPECT_NEAR(times.at(S(2)) - times.at(S(1)), 2.5, 0.01);
}

}  // namespace
}  // namespace cairn
